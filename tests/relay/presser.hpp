#pragma once
/// A client of 100 Hz with the shipped library, in a thread of its own. It asks for force, presses
/// slowly, and asks again if force was lost.

#include <atomic>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>

#include "haptic/client/client.hpp"
#include "tests/support/within.hpp"

namespace haptic::test {

/// The number of the newest sample in use never goes back within one lease.
class UsedInOrder {
 public:
  void add(const client::DeviceState& state);
  [[nodiscard]] bool holds() const { return holds_; }

 private:
  std::atomic<bool> holds_{true};
  std::uint64_t newest_used_{0};
  std::uint32_t epoch_{0};
};

class Presser {
 public:
  static constexpr double kRate = 100.0;      ///< Hz
  static constexpr double kFreshEnd = 0.025;  ///< s, 2.5 periods

  /// Opens the session; throws ClientError.
  explicit Presser(const std::string& address);
  ~Presser();

  [[nodiscard]] client::Session& session() { return *session_; }
  [[nodiscard]] bool heard(const std::string& reason) const;
  [[nodiscard]] client::DeviceState state() const { return session_->state(); }
  [[nodiscard]] bool in_order() const { return order_.holds(); }

 private:
  void run();

  client::Connection connection_;
  mutable std::mutex mutex_;
  std::set<std::string> events_{};
  UsedInOrder order_{};
  std::atomic<bool> running_{true};
  std::unique_ptr<client::Session> session_{};
  std::thread thread_{};
};

/// The finger at `address` comes to rest (IDLE) within a minute.
[[nodiscard]] bool serves(const std::string& address);

}  // namespace haptic::test
