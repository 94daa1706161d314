#pragma once
/// What a connection's bytes came to (private to the front). Every byte that a peer sends must be
/// part of something that the service understood; what is not is a debt.

#include <algorithm>
#include <atomic>
#include <cstdint>

namespace haptic::server {

/// What the service says of a connection. Any thread.
class Account {
 public:
  /// A message of so many bytes, with what HTTP/2 and gRPC put around it.
  void message(std::size_t bytes) noexcept { add(bytes + kFrame); }
  /// A call, with its headers in full and a request of so many bytes.
  void call(std::size_t bytes) noexcept { add(bytes + kHeaders); }
  /// Session streams that are open on it: such a connection gives way last.
  void session_opened() noexcept { sessions_.fetch_add(1, std::memory_order_relaxed); }
  void session_ended() noexcept { sessions_.fetch_sub(1, std::memory_order_relaxed); }

  [[nodiscard]] std::uint64_t understood() const noexcept {
    return understood_.load(std::memory_order_relaxed);
  }
  /// What is lost if it is cut: 2 a session, 1 a peer that made a call, 0 nothing so far.
  [[nodiscard]] int worth() const noexcept {
    if (sessions_.load(std::memory_order_relaxed) > 0) return 2;
    return understood() > 0 ? 1 : 0;
  }

 private:
  static constexpr std::size_t kFrame = 32;     ///< 9 + 5 bytes, and a record of TLS
  static constexpr std::size_t kHeaders = 512;  ///< gRPC's own clients send 200 to 400
  void add(std::size_t bytes) noexcept { understood_.fetch_add(bytes, std::memory_order_relaxed); }

  std::atomic<std::uint64_t> understood_{0};
  std::atomic<int> sessions_{0};
};

/// Totals of a connection since its beginning.
struct Traffic {
  std::uint64_t understood{0};    ///< Account::understood(), read before the two others
  std::uint64_t received{0};      ///< by gRPC: what waits in the kernel costs nothing yet
  std::uint64_t acknowledged{0};  ///< sent to the peer, and arrived there
};

/// Of a TCP connection, as the kernel counts it.
[[nodiscard]] Traffic traffic_of(int socket, const Account& account);

/// A connection's debt: what it sent beyond what was understood, never below 0, so that good
/// conduct saves nothing up. One thread.
class Debt {
 public:
  /// `forgiven`: bytes, for the time since the last call.
  void book(const Traffic& now, double forgiven) noexcept {
    const auto grown = [](std::uint64_t& before, std::uint64_t value) {
      const std::uint64_t step = value > before ? value - before : 0;
      before = std::max(before, value);
      return static_cast<double>(step);
    };
    // Twice a message: HTTP/2 may add padding and frames without content to it. Half of what was
    // sent: a client that only listens answers states with window updates and pings.
    const double paid = 2.0 * grown(last_.understood, now.understood) +
                        0.5 * grown(last_.acknowledged, now.acknowledged) + forgiven;
    bytes_ = std::max(0.0, bytes_ + grown(last_.received, now.received) - paid);
  }
  [[nodiscard]] double bytes() const noexcept { return bytes_; }
  /// Everything that was never understood, since the beginning.
  [[nodiscard]] std::uint64_t unexplained() const noexcept {
    return last_.received > last_.understood ? last_.received - last_.understood : 0;
  }

 private:
  Traffic last_{};
  double bytes_{0.0};
};

}  // namespace haptic::server
