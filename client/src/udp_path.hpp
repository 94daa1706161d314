#pragma once
/// The client's end of a session's UDP path: a socket, a thread, and wire::PathEnd under a mutex.

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "haptic/v1/session.pb.h"

namespace haptic::client {

/// Where a path's news go; called on the path's thread, with no lock of the path's held.
class UdpSink {
 public:
  virtual ~UdpSink() = default;
  virtual void on_udp_state(const v1::DeviceState& state) = 0;
  /// Samples go by the stream again, or as well; `newest` is the last one that went by UDP, and may
  /// be lost.
  virtual void on_udp_fallback(const v1::ProxySample& newest) = 0;
};

/// Whether a sample went by UDP.
enum class ByUdp : std::uint8_t {
  kNo,       ///< the path is not in use: the stream's then
  kYes,      ///< nothing more to do
  kInDoubt,  ///< it did, but answers are overdue: the stream should carry it too
};

/// What is known of the path at the moment.
struct UdpFigures {
  bool in_use{false};
  std::chrono::nanoseconds round_trip{0};  ///< smoothed; 0: not known yet
  std::uint64_t received{0}, lost{0};      ///< datagrams of the server
};

class UdpPath {
 public:
  /// `host` stands in where the offer names none. `sink` must outlive stop(). Throws ClientError
  /// where the offer has no keys.
  UdpPath(const v1::UdpPath& offer, const std::string& host, std::chrono::nanoseconds period,
          UdpSink& sink);
  /// Only after stop().
  ~UdpPath();
  UdpPath(const UdpPath&) = delete;
  UdpPath& operator=(const UdpPath&) = delete;

  /// Leaves the path and ends the thread; waits for a call of the sink's that is under way. Not
  /// from there. Idempotent.
  void stop();

  /// Any thread, never waits for the network.
  [[nodiscard]] ByUdp send(const v1::ProxySample& sample);
  /// New keys came on the stream.
  void rekey(const v1::UdpPath& offer);
  [[nodiscard]] UdpFigures figures() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// The host of an address as gRPC takes it; 127.0.0.1 for a UNIX socket.
[[nodiscard]] std::string udp_host(const std::string& address);

}  // namespace haptic::client
