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

class Presser {
 public:
  static constexpr double kRate = 100.0;      ///< Hz
  static constexpr double kFreshEnd = 0.025;  ///< s, 2.5 periods

  /// Opens the session; throws ClientError.
  explicit Presser(const std::string& address,
                   client::Carriers carriers = client::Carriers::kAutomatic);
  ~Presser();

  [[nodiscard]] client::Session& session() { return *session_; }
  [[nodiscard]] bool heard(const std::string& reason) const;
  [[nodiscard]] client::DeviceState state() const { return session_->state(); }
  /// The number of the newest sample in use never went back within one lease.
  [[nodiscard]] bool in_order() const { return in_order_; }
  std::atomic<bool> publishing{true};
  /// While set, published in place of every coordinate.
  std::atomic<const double*> instead{nullptr};

 private:
  void run();
  void on_state(const client::DeviceState& state);

  client::Connection connection_;
  mutable std::mutex mutex_;
  std::set<std::string> events_{};
  std::atomic<bool> in_order_{true}, running_{true};
  std::uint64_t newest_used_{0};
  std::uint32_t epoch_{0};
  std::unique_ptr<client::Session> session_{};
  std::thread thread_{};
};

/// The finger at `address` comes to rest (IDLE) within a minute.
[[nodiscard]] bool serves(const std::string& address);

}  // namespace haptic::test
