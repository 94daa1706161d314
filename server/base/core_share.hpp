#pragma once
/// Keeps a thread of real-time priority to a third of a core: whatever others send it, ordinary
/// programs go on.

#include <thread>

#include "server/base/steady_now.hpp"

namespace haptic::server {

class CoreShare {
 public:
  /// After each piece of work, which began then: sleeps if there was too much of it.
  void rest(core::TimePoint began) {
    constexpr core::Duration kWindow = std::chrono::milliseconds(3);
    constexpr core::Duration kBudget = std::chrono::milliseconds(1);
    const core::TimePoint now = steady_now();
    busy_ += now - began;
    if (now - window_ < kWindow) {
      if (busy_ < kBudget) return;
      std::this_thread::sleep_for(window_ + kWindow - now);
    }
    window_ = steady_now();
    busy_ = {};
  }

 private:
  core::TimePoint window_{};  ///< began then
  core::Duration busy_{0};    ///< of the window
};

}  // namespace haptic::server
