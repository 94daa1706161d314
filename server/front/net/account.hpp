#pragma once
/// Account of a connection's bytes (private to the front). Every byte that a peer sends must be
/// part of something that the service understood; what is not is a debt.

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

#include "haptic/core/time.hpp"

namespace haptic::server {

/// The service's judgement of a connection. Any thread.
class Account {
 public:
  /// A message of so many bytes, with what HTTP/2 and gRPC put around it.
  void message(std::size_t bytes) noexcept {
    add(bytes + kFrame);
    messages_.fetch_add(bytes + kFrame, std::memory_order_relaxed);
  }
  /// A call, with its headers in full and a request of so many bytes.
  void call(std::size_t bytes) noexcept { add(bytes + kHeaders); }
  /// A call began that lives until the service has ended it, whether or not its peer took it back.
  void call_began() noexcept { calls_.fetch_add(1, std::memory_order_relaxed); }
  void call_ended() noexcept { calls_.fetch_sub(1, std::memory_order_relaxed); }
  [[nodiscard]] unsigned calls() const noexcept { return calls_.load(std::memory_order_relaxed); }
  /// Session streams that are open on it: such a connection gives way last.
  void session_opened() noexcept { sessions_.fetch_add(1, std::memory_order_relaxed); }
  void session_ended() noexcept { sessions_.fetch_sub(1, std::memory_order_relaxed); }

  /// The service has closed the connection, without shutting it down: the door's copy of the
  /// descriptor still keeps it up.
  void leave() noexcept { left_.store(true, std::memory_order_relaxed); }
  [[nodiscard]] bool left() const noexcept { return left_.load(std::memory_order_relaxed); }

  [[nodiscard]] std::uint64_t understood() const noexcept {
    return understood_.load(std::memory_order_relaxed);
  }
  /// The part of it that was messages of streams.
  [[nodiscard]] std::uint64_t messages() const noexcept {
    return messages_.load(std::memory_order_relaxed);
  }
  /// The loss if it is cut: 2 a session, 1 a peer that made a call, 0 nothing so far.
  [[nodiscard]] int worth() const noexcept {
    if (sessions_.load(std::memory_order_relaxed) > 0) return 2;
    return understood() > 0 ? 1 : 0;
  }

 private:
  static constexpr std::size_t kFrame = 32;     ///< 9 + 5 bytes, and a record of TLS
  static constexpr std::size_t kHeaders = 512;  ///< gRPC's own clients send 200 to 400
  void add(std::size_t bytes) noexcept { understood_.fetch_add(bytes, std::memory_order_relaxed); }

  std::atomic<std::uint64_t> understood_{0}, messages_{0};
  std::atomic<unsigned> calls_{0};
  std::atomic<int> sessions_{0};
  std::atomic<bool> left_{false};
};

/// A call of a connection, as long as this lives.
class BookedCall {
 public:
  /// Null: it is not booked.
  explicit BookedCall(std::shared_ptr<Account> account) : account_(std::move(account)) {
    if (account_) account_->call_began();
  }
  ~BookedCall() {
    if (account_) account_->call_ended();
  }
  BookedCall(const BookedCall&) = delete;
  BookedCall& operator=(const BookedCall&) = delete;

 private:
  const std::shared_ptr<Account> account_;
};

/// Totals of a connection since its beginning.
struct Traffic {
  std::uint64_t understood{0};    ///< Account::understood(), read before what follows
  std::uint64_t messages{0};      ///< Account::messages()
  std::uint64_t received{0};      ///< by gRPC: what waits in the kernel costs nothing yet
  std::uint64_t unread{0};        ///< written for the peer, and not acknowledged yet
  std::uint64_t acknowledged{0};  ///< sent to the peer, and arrived there
};

/// Finds out if a peer asks and does not read the answers. One thread.
class Unread {
 public:
  [[nodiscard]] bool book(const Traffic& traffic, core::TimePoint now) noexcept {
    if (traffic.unread < kUnread || traffic.acknowledged != since_.acknowledged) {
      since_ = traffic;
      stuck_ = now;
    }
    return now - stuck_ > kPatience && traffic.received - since_.received > kAsked;
  }

 private:
  static constexpr std::uint64_t kUnread = 16 * 1024;
  static constexpr std::uint64_t kAsked = 8 * 1024;
  static constexpr core::Duration kPatience = std::chrono::milliseconds(300);
  Traffic since_{};
  core::TimePoint stuck_{};
};

/// Growth of a total since the last time, never below 0.
inline double grown(std::uint64_t& before, std::uint64_t value) noexcept {
  const std::uint64_t step = value > before ? value - before : 0;
  before = std::max(before, value);
  return static_cast<double>(step);
}

/// Counts the bytes of a connection that can have cost memory lately: all but messages of streams
/// and answers to states. They may have begun calls, and gRPC keeps a thousand times as much of a
/// call until it is over. One thread.
class Suspicion {
 public:
  /// `since`: s since the last time.
  void book(const Traffic& now, double since) noexcept {
    const std::uint64_t other = now.received - std::min(now.received, now.messages);
    // gRPC's clients answer states with window updates and pings: 47 bytes to 344 that arrived.
    const double answers = kAnswers * grown(acknowledged_, now.acknowledged);
    const double step = grown(other_, other) + early_ - answers;
    early_ = std::clamp(step, -kEarly, 0.0);
    bytes_ = bytes_ * std::max(0.0, 1.0 - since) + std::max(0.0, step);
  }
  /// Bytes within a second or so.
  [[nodiscard]] double bytes() const noexcept { return bytes_; }

 private:
  static constexpr double kAnswers = 0.2;
  static constexpr double kEarly = 2048.0;  ///< of answers that may still come
  std::uint64_t other_{0}, acknowledged_{0};
  double early_{0.0};
  double bytes_{0.0};
};

/// Traffic of a TCP connection, as the kernel counts it.
[[nodiscard]] Traffic traffic_of(int socket, const Account& account);

/// A connection's debt: what it sent beyond what was understood, never below 0, so that good
/// conduct saves nothing up. One thread.
class Debt {
 public:
  /// `forgiven`: bytes, for the time since the last call.
  void book(const Traffic& now, double forgiven) noexcept {
    // Twice a message: HTTP/2 may add padding and frames without content to it. Half of what was
    // sent: a client that only listens answers states with window updates and pings.
    const double paid = 2.0 * grown(last_.understood, now.understood) +
                        0.5 * grown(last_.acknowledged, now.acknowledged) + forgiven;
    bytes_ = std::max(0.0, bytes_ + grown(last_.received, now.received) - paid);
  }
  [[nodiscard]] double bytes() const noexcept { return bytes_; }

 private:
  Traffic last_{};
  double bytes_{0.0};
};

}  // namespace haptic::server
