#pragma once
/// The server's UDP socket and its thread. Every datagram that waits is taken at once, stamped with
/// its arrival, and given to the path that its path id names. Samples go on to the session and
/// through the same ingress as those of the stream, in the order of arrival. The ingress's mailbox
/// keeps the newest.
///
/// A datagram that fails is dropped without an answer and counted: by its path if that is known,
/// else here.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "server/base/descriptor.hpp"
#include "server/base/steady_now.hpp"
#include "server/front/udp/server_path.hpp"

namespace haptic::server {

class UdpPort {
 public:
  /// `bound`: a UDP socket that is. `streams`: the addresses that sessions are opened at. Throws
  /// core::TransportError.
  explicit UdpPort(Descriptor bound, const std::vector<std::string>& streams = {},
                   ArrivalClock clock = steady_arrival);
  /// stop().
  ~UdpPort();
  UdpPort(const UdpPort&) = delete;
  UdpPort& operator=(const UdpPort&) = delete;

  void start();
  /// Ends the thread. Idempotent.
  void stop();

  /// A path for a session, with fresh keys; `nominal_period` is that of its samples, or of its
  /// states if it sends none. Any thread.
  struct Opened {
    std::shared_ptr<ServerPath> path{};
    wire::PathKeys keys{};
  };
  [[nodiscard]] Opened open(std::weak_ptr<UdpSink> sink, core::Duration nominal_period);
  /// Tells the client, and forgets the path. Any thread but the port's own inside a sink.
  void close(const std::shared_ptr<ServerPath>& path);
  /// Fresh keys for a path now; by itself that happens when the old ones wear out. Any thread.
  void rekey(const std::shared_ptr<ServerPath>& path);

  /// Path ids in use: of each path the current one, the previous one until the next rekey, and the
  /// next one during a rekey.
  [[nodiscard]] std::size_t path_ids() const;
  /// The bound address's. Empty if that is any address of this host, or one at which streams are
  /// served too: a client uses the name that it opened its stream to, because a relay or a
  /// translator in between may have changed the address.
  [[nodiscard]] const std::string& host() const;
  [[nodiscard]] std::uint16_t port() const;
  /// Datagrams that no path answers for: length, magic, version, type, unknown path.
  [[nodiscard]] std::uint64_t rejected(wire::Rejection why) const;
  /// The same and what paths dropped, those that are closed by now among them.
  [[nodiscard]] std::uint64_t dropped(wire::Rejection why) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptic::server
