#pragma once
/// The UDP path of one session at the server: wire::PathEnd under a mutex, between the port's
/// thread and the threads that send states.

#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "haptic/core/time.hpp"
#include "haptic/v1/session.pb.h"
#include "haptic/wire/path_end.hpp"

namespace haptic::server {

/// What a path tells its session, on the port's thread, with no lock of the path's held.
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
  [[nodiscard]] bool in_use() const;
  [[nodiscard]] wire::LinkCounters counters() const;
  [[nodiscard]] wire::RoundTrip round_trip() const;
  /// The client's steady clock against the server's, by the path's challenges.
  [[nodiscard]] std::optional<wire::ClockOffset::Estimate> clock(core::TimePoint now) const;
  /// What the client says it received of the server's datagrams, under the keys in use.
  [[nodiscard]] wire::PeerReport peer_report() const;

  // The port's.
  wire::Rejection receive(wire::ConstBytes datagram, const wire::PeerAddress& from,
                          core::TimePoint arrival);
  void step(core::TimePoint now);
  [[nodiscard]] core::TimePoint next_step() const;
  [[nodiscard]] bool wants_rekey(core::TimePoint now) const;
  /// Its datagrams may come under this path id: of its keys, the next ones or, for a while, the
  /// former.
  [[nodiscard]] bool knows(std::uint32_t path_id, core::TimePoint now);
  /// Prepares both ends: this one here, the client's by the sink.
  void rekey(const wire::PathKeys& keys);
  void close();

 private:
  void tell(wire::PathChange change);

  mutable std::mutex mutex_;
  wire::PathEnd end_;
  v1::ProxySample sample_{};  ///< the port's thread only; keeps its memory
  const std::weak_ptr<UdpSink> sink_;
};

}  // namespace haptic::server
