#pragma once
/// Counts heap allocations of the calling thread: a property that tests assert of the real-time
/// path. Linking this file replaces the program's operator new and delete and wraps malloc's
/// family.

#include <cstdint>

namespace haptic::test {

class AllocationGuard {
 public:
  AllocationGuard() noexcept;
  /// Allocations and releases of this thread since construction.
  [[nodiscard]] std::uint64_t allocations() const noexcept;
  [[nodiscard]] std::uint64_t releases() const noexcept;

 private:
  std::uint64_t allocations_;
  std::uint64_t releases_;
};

}  // namespace haptic::test
