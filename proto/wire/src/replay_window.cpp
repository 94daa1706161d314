#include "haptic/wire/replay_window.hpp"

namespace haptic::wire {

ReplayWindow::Verdict ReplayWindow::check(std::uint64_t number) const noexcept {
  if (number == 0) return Verdict::kTooOld;
  if (number > newest_) return Verdict::kNew;
  if (newest_ - number >= kSize) return Verdict::kTooOld;
  return (seen_[word(number)] & bit(number)) != 0 ? Verdict::kDuplicate : Verdict::kNew;
}

void ReplayWindow::commit(std::uint64_t number) noexcept {
  if (number > newest_) {
    // What the window leaves behind makes room for the numbers between the old newest and this one.
    if (number - newest_ >= kSize) {
      seen_ = {};
    } else {
      for (std::uint64_t skipped = newest_ + 1; skipped < number; ++skipped) {
        seen_[word(skipped)] &= ~bit(skipped);
      }
    }
    newest_ = number;
  }
  seen_[word(number)] |= bit(number);
}

}  // namespace haptic::wire
