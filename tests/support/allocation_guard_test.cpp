// The positive control: if the guard saw nothing, every "does not allocate" test would pass.
#include "tests/support/allocation_guard.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstdlib>
#include <utility>

namespace {

using haptic::test::AllocationGuard;

/// Hides a pointer from the optimiser, which may otherwise remove an allocation and its release.
template <typename T>
T* escape(T* pointer) {
  asm volatile("" : "+r"(pointer) : : "memory");
  return pointer;
}

struct alignas(256) OverAligned {
  char bytes[256];
};

// NOLINTBEGIN(cppcoreguidelines-no-malloc): the ways to the heap are the subject.
TEST(AllocationGuard, SeesEveryWayToTheHeap) {
  const std::pair<const char*, void (*)()> ways[] = {
      {"new", [] { delete escape(new int(1)); }},
      {"new[]", [] { delete[] escape(new int[8]); }},
      {"over-aligned new", [] { delete escape(new OverAligned); }},
      {"malloc", [] { free(escape(static_cast<char*>(malloc(24)))); }},
      {"calloc", [] { free(escape(static_cast<char*>(calloc(3, 8)))); }},
      {"realloc",
       [] {
         auto* block = escape(static_cast<char*>(malloc(8)));
         free(escape(static_cast<char*>(realloc(block, 1 << 16))));
       }},
#ifndef __SANITIZE_THREAD__  // g++ 12's libtsan calls no hook for these two
      {"aligned_alloc", [] { free(escape(static_cast<char*>(aligned_alloc(64, 128)))); }},
      {"posix_memalign",
       [] {
         void* block = nullptr;
         ASSERT_EQ(posix_memalign(&block, 64, 128), 0);
         free(escape(block));
       }},
#endif
      {"Eigen", [] { escape(Eigen::VectorXd(Eigen::VectorXd::Ones(5)).data()); }}};
  for (const auto& [name, run] : ways) {
    const AllocationGuard guard;
    run();
    const auto allocations = guard.allocations(), releases = guard.releases();
    EXPECT_GE(allocations, 1u) << name;
    EXPECT_EQ(allocations, releases) << name;
  }
}
// NOLINTEND(cppcoreguidelines-no-malloc)

}  // namespace
