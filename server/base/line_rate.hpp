#pragma once
/// Lines of the log that another program can cause: only so many a second, and then their number.

#include <cstdint>
#include <optional>
#include <utility>

#include "haptic/core/time.hpp"

namespace haptic::server {

/// One thread.
class LineRate {
 public:
  static constexpr unsigned kLinesPerSecond = 5;

  /// How many were left out before this one; absent: this one is left out too.
  [[nodiscard]] std::optional<std::uint64_t> next(core::TimePoint now) noexcept {
    if (told_ == 0 || now - since_ >= std::chrono::seconds(1)) {
      since_ = now;
      told_ = 0;
    }
    if (told_ >= kLinesPerSecond) {
      ++left_out_;
      return std::nullopt;
    }
    ++told_;
    return std::exchange(left_out_, 0);
  }

 private:
  core::TimePoint since_{};
  unsigned told_{0};
  std::uint64_t left_out_{0};
};

}  // namespace haptic::server
