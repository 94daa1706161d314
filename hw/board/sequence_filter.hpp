#pragma once
/// Which frames of a link are newer than those before, and how many are missing.

#include <cstdint>

namespace haptic::hw::board {

/// Sequence numbers rise by one per frame and wrap (RFC 1982). A number that is not ahead of the
/// last accepted one belongs to a frame that was repeated or came too late.
class SequenceFilter {
 public:
  /// Restarts at `seq`, which counts as accepted.
  void restart(std::uint32_t seq) noexcept { last_ = seq; }
  /// True if `seq` is newer. Adds the skipped numbers to lost().
  [[nodiscard]] bool accept(std::uint32_t seq) noexcept {
    const std::uint32_t ahead = seq - last_;
    if (ahead == 0 || ahead >= 0x80000000U) return false;
    lost_ += ahead - 1;
    last_ = seq;
    return true;
  }
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }

 private:
  std::uint32_t last_{0};
  std::uint64_t lost_{0};
};

}  // namespace haptic::hw::board
