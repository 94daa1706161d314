#include "haptic/wire/replay_window.hpp"

namespace haptic::wire {

Rejection ReplayWindow::check(std::uint64_t number) const noexcept {
  if (number == 0) return Rejection::kTooOld;
  if (number > newest_) return Rejection::kNone;
  if (newest_ - number >= kSize) return Rejection::kTooOld;
  return seen_[number % kSize] ? Rejection::kDuplicate : Rejection::kNone;
}

void ReplayWindow::commit(std::uint64_t number) noexcept {
  if (number > newest_) {
    // The numbers that the window leaves behind make room for the numbers between the old newest
    // and this one.
    if (number - newest_ >= kSize) {
      seen_.reset();
    } else {
      for (std::uint64_t n = newest_ + 1; n < number; ++n) seen_[n % kSize] = false;
    }
    newest_ = number;
  }
  seen_[number % kSize] = true;
}

}  // namespace haptic::wire
