#pragma once
/// The server's UDP socket and its thread: every datagram that waits is taken at once, stamped with
/// its arrival, and given to the path that its path id names; samples go on to the session and
/// through the same ingress as those of the stream, in the order of arrival. The ingress's mailbox
/// keeps the newest.
///
/// What fails is dropped without a word and counted: by its path once one is known, else here.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "server/base/steady_now.hpp"
#include "server/udp/udp_path.hpp"

namespace haptic::server {

class UdpPort {
 public:
  /// Binds `listen`, "host:port" (port 0: any free one), loopback only while there is no TLS.
  /// Throws TransportError. `streams`: the addresses that sessions are opened at.
  explicit UdpPort(const std::string& listen, const std::vector<std::string>& streams = {},
                   ArrivalClock clock = steady_arrival);
  /// stop().
  ~UdpPort();
  UdpPort(const UdpPort&) = delete;
  UdpPort& operator=(const UdpPort&) = delete;

  void start();
  /// Ends the thread. Idempotent.
  void stop();

  /// A path for a session, with fresh keys; `nominal_period` is that of its samples, or of its
  /// states where it sends none. Any thread.
  struct Opened {
    std::shared_ptr<UdpPath> path{};
    wire::PathKeys keys{};
  };
  [[nodiscard]] Opened open(std::weak_ptr<UdpSink> sink, core::Duration nominal_period);
  /// Tells the client, and forgets the path. Any thread but the port's own inside a sink.
  void close(const std::shared_ptr<UdpPath>& path);
  /// Fresh keys for a path now; by itself that happens when the old ones wear out. Any thread.
  void rekey(const std::shared_ptr<UdpPath>& path);

  /// Those that lead to a path: of each its keys', once keys changed the former, which is forgotten
  /// at the next change, and while they change the next.
  [[nodiscard]] std::size_t path_ids() const;
  /// Of the address bound; host empty where that is any address of this host, or where streams are
  /// served at the same: a client knows that one by the name it came by, which a relay or a
  /// translator between may have changed.
  [[nodiscard]] std::string host() const;
  [[nodiscard]] std::uint16_t port() const;
  /// Datagrams that no path answers for: length, magic, version, type, unknown path.
  [[nodiscard]] std::uint64_t rejected(wire::Rejection why) const;
  /// The same and what paths dropped, those that are closed by now among them.
  [[nodiscard]] std::uint64_t dropped(wire::Rejection why) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptic::server
