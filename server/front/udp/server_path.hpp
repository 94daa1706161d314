#pragma once
/// The UDP path of one session at the server: wire::PathEnd under a mutex, between the port's
/// thread and the threads that send states.

#include <memory>
#include <mutex>

#include "haptic/core/time.hpp"
#include "haptic/v1/session.pb.h"
#include "haptic/wire/path_end.hpp"

namespace haptic::server {

/// Calls of a path to its session, on the port's thread, with no lock of the path's held.
class UdpSink {
 public:
  virtual ~UdpSink() = default;
  virtual void on_udp_sample(const v1::ProxySample& sample, core::TimePoint arrival) = 0;
  /// The way of the states changed its carrier, or could not.
  virtual void on_udp_change(wire::PathChange change) = 0;
  /// New keys, to be handed to the client on the stream.
  virtual void on_udp_keys(const wire::PathKeys& keys) = 0;
};

class ServerPath {
 public:
  ServerPath(wire::PathEndSetup setup, std::weak_ptr<UdpSink> sink);

  /// A serialised DeviceState. Any thread, never blocks. False if the path is not in use.
  [[nodiscard]] bool send_state(wire::ConstBytes state);
  /// `read(path_end)` under the mutex: figures, the client's clock, what is due.
  template <typename Read>
  auto with(const Read& read) {
    const std::lock_guard lock(mutex_);
    return read(end_);
  }

  // The port's.
  wire::Rejection receive(wire::ConstBytes datagram, const wire::PeerAddress& from,
                          core::TimePoint arrival);
  void step(core::TimePoint now);
  /// Prepares both ends: this one here, the client's by the sink.
  void rekey(const wire::PathKeys& keys);

 private:
  void tell(wire::PathChange change);

  std::mutex mutex_;
  wire::PathEnd end_;
  v1::ProxySample sample_{};  ///< the port's thread only; keeps its memory
  const std::weak_ptr<UdpSink> sink_;
};

}  // namespace haptic::server
