#pragma once
/// The door of the front: accepts every connection, hands it to gRPC, and decides which of them may
/// stay. gRPC by itself accepts until descriptors run out, and waits for ever for the end of a
/// header or a message.
///
/// | bound                    | what gives way                                                   |
/// |--------------------------|------------------------------------------------------------------|
/// | connections of a peer    | its oldest one that made no call; then without a session; then   |
/// |                          | any                                                              |
/// | connections in all       | the same, of the peer that has most                              |
/// | bytes without a meaning  | the connection itself; in all: the one with most of them         |
/// | calls that are not over  | the connection itself: its peer takes calls back and begins more |
/// |                          | of them, or reads no answers                                     |
/// | answers that are not read| the connection itself, unless it has a session                   |
/// | memory that grows fast,  | those that sent most lately, other than messages of streams; the |
/// | or too much in use       | door is shut until it is given back, for 5 s at most             |
/// | bytes before it is in    | the connection itself: more than 16 KB waited when it was let in |
/// | nothing acknowledged 8 s | the connection itself, by the kernel                             |
///
/// After a connection was cut for what its peer did, the door is shut for 100 ms.
///
/// Bytes are the kernel's count (TCP_INFO), so that neither TLS nor a codec is in the way. It has
/// none for UNIX sockets, only whose number is bounded: they are users of this host.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "haptic/core/time.hpp"
#include "server/base/descriptor.hpp"
#include "server/front/net/account.hpp"

namespace haptic::server {

struct ConnectionLimits {
  unsigned all{256};
  unsigned per_peer{96};  ///< of an IPv4 address, the /64 of an IPv6 address, or a local user
  /// Bytes that came to nothing: more than the largest message, whose end is awaited.
  std::uint64_t debt{320 * 1024};
  std::uint64_t debt_of_all{512 * 1024};
  unsigned calls{256};  ///< of a connection that gRPC has, taken back by the peer or not
  std::uint64_t forgiven_per_second{1024};   ///< pings, health checks
  std::uint64_t growth{8ull * 1024 * 1024};  ///< of the process's own memory, within 1 s
  /// Memory of the process, as malloc counts it. 256 connections, sessions and watches take 20 MB.
  std::uint64_t memory{32ull * 1024 * 1024};
};

/// So many descriptors are kept for everything but connections.
inline constexpr unsigned kReservedDescriptors = 48;

/// `limits`, lowered to the descriptors that this process may have, which it raises as far
/// as it may. Throws core::TransportError if there is room for hardly any connection.
[[nodiscard]] ConnectionLimits within_descriptors(ConnectionLimits limits);
/// Throws core::TransportError if the process may not start as many threads as gRPC will: gRPC
/// itself aborts.
void require_threads();

class Connections {
 public:
  /// Takes the descriptor. `address`: the index of the address it came by.
  using HandOver =
      std::function<void(std::size_t address, int descriptor, std::shared_ptr<Account> account)>;

  struct Listener {
    Descriptor socket{};
    std::size_t address{0};  ///< index of the address; a name may stand for several sockets
  };
  /// `listeners`: bound and listening, non-blocking.
  Connections(std::vector<Listener> listeners, const ConnectionLimits& limits);
  /// Cuts what is open.
  ~Connections();
  Connections(const Connections&) = delete;
  Connections& operator=(const Connections&) = delete;

  /// Accepts, on a thread of its own.
  void start(HandOver hand_over);
  /// Accepts no more; what is still open after `grace` is cut. Returns at once.
  void close(core::Duration grace);

  /// Account of the connection that gRPC calls `peer` ("ipv4:127.0.0.1:5000"). That of a UNIX
  /// socket, or of a connection that is gone, is read by no one.
  [[nodiscard]] std::shared_ptr<Account> account(const std::string& peer);
  [[nodiscard]] std::size_t open() const;
  /// Looks at the accounts soon. Any thread.
  void look_now();
  /// Connections that were cut since the start.
  [[nodiscard]] std::uint64_t cut() const noexcept { return cut_.load(); }

 private:
  struct Connection;
  void run() noexcept;
  void accept_all(const Listener& listener);
  void admit(std::size_t address, Descriptor socket);
  /// Cuts the connection that gives way first among those of `peer`.
  void make_room(const std::string& peer);
  [[nodiscard]] std::string largest_peer() const;
  void forget_closed();
  void look_after(core::TimePoint now);
  void look_at_memory(core::TimePoint now);
  void cut_suspects(core::TimePoint now);
  void cut(Connection& connection, const char* why);
  void offends(Connection& connection, const char* why);
  void stop();

  const ConnectionLimits limits_;
  HandOver hand_over_{};
  std::vector<Listener> listeners_;  ///< none from close() on
  Descriptor
      spare_;  ///< given up for a moment when descriptors run out, to accept one and close it
  const Descriptor wakes_;
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Connection>> open_{};  ///< the oldest first; changed by the thread
  const std::shared_ptr<Account> unread_{std::make_shared<Account>()};
  std::atomic<std::uint64_t> cut_{0};
  core::TimePoint looked_{}, told_{}, memory_at_{}, heap_at_{}, accepts_at_{};
  bool hurry_{false};               ///< a peer may be up to something
  bool trim_{false};                ///< a connection was cut since the heap was trimmed
  std::uint64_t resident_{0};       ///< a second ago, or less
  bool full_{false};                ///< too much memory was in use: no one comes in, but not for
  core::TimePoint shut_until_{};    ///< longer than this
  std::atomic<bool> asked_{false};  ///< to look now
  std::atomic<bool> stopping_{false};
  std::atomic<core::Duration::rep> cut_at_{0};  ///< since the clock's epoch; 0: not closing
  std::thread thread_{};
};

}  // namespace haptic::server
