// The positive control: a guard that sees nothing would let every "does not allocate" test pass.
#include "tests/support/allocation_guard.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstdlib>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

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

/// One thing that allocates and releases again, with the fewest of each that must be seen.
struct Case {
  const char* name;
  std::function<void()> run;
};
void PrintTo(const Case& a_case, std::ostream* out) {
  *out << a_case.name;
}

class AllocationGuardSees : public testing::TestWithParam<Case> {};

TEST_P(AllocationGuardSees, AnAllocationAndItsRelease) {
#ifdef __SANITIZE_THREAD__
  const std::string_view name = GetParam().name;
  if (name == "AlignedAlloc" || name == "PosixMemalign") {
    GTEST_SKIP() << "g++ 12's libtsan calls no hook for these two; other builds count them";
  }
#endif
  const auto& run = GetParam().run;
  const AllocationGuard guard;
  run();
  const auto allocations = guard.allocations();
  const auto releases = guard.releases();
  EXPECT_GE(allocations, 1u);
  EXPECT_EQ(allocations, releases);
}

// NOLINTBEGIN(cppcoreguidelines-no-malloc): the ways to the heap are the subject.
INSTANTIATE_TEST_SUITE_P(
    EveryWayToTheHeap, AllocationGuardSees,
    testing::Values(
        Case{"New", [] { delete escape(new int(1)); }},
        Case{"NewArray", [] { delete[] escape(new int[8]); }},
        Case{"NewOverAligned", [] { delete escape(new OverAligned); }},
        Case{"Malloc", [] { free(escape(static_cast<char*>(malloc(24)))); }},
        Case{"Calloc", [] { free(escape(static_cast<char*>(calloc(3, 8)))); }},
        Case{"Realloc",
             [] {
               auto* block = escape(static_cast<char*>(malloc(8)));
               free(escape(static_cast<char*>(realloc(block, 1 << 16))));
             }},
        Case{"AlignedAlloc", [] { free(escape(static_cast<char*>(aligned_alloc(64, 128)))); }},
        Case{"PosixMemalign",
             [] {
               void* block = nullptr;
               ASSERT_EQ(posix_memalign(&block, 64, 128), 0);
               free(escape(block));
             }},
        Case{"VectorGrowth",
             [] {
               std::vector<int> values;
               for (int i = 0; i < 100; ++i) values.push_back(i);
               escape(values.data());
             }},
        Case{"String", [] { escape(std::string(100, 'x').data()); }},
        Case{"SharedPointer", [] { escape(std::make_shared<int>(1).get()); }},
        Case{"EigenDynamic", [] { escape(Eigen::VectorXd(Eigen::VectorXd::Ones(5)).data()); }},
        Case{"EigenTemporary",
             [] {
               const Eigen::MatrixXd a = Eigen::MatrixXd::Ones(4, 4);
               Eigen::MatrixXd b = a;
               b = b * a;
               escape(b.data());
             }}),
    [](const auto& a_case) { return std::string(a_case.param.name); });

TEST(AllocationGuard, CountsEachAllocationOnce) {
  const AllocationGuard guard;
  auto* block = escape(static_cast<char*>(malloc(8)));
  EXPECT_EQ(guard.allocations(), 1u);
  EXPECT_EQ(guard.releases(), 0u);
  free(block);
  EXPECT_EQ(guard.releases(), 1u);
}
// NOLINTEND(cppcoreguidelines-no-malloc)

TEST(AllocationGuard, CallsNothingAnAllocationThatIsNone) {
  double sum = 0.0;
  const AllocationGuard guard;
  Eigen::Matrix3d a = Eigen::Matrix3d::Identity();
  a = (a * a).eval();
  sum += a.sum() + *escape(a.data());
  free(nullptr);
  EXPECT_EQ(guard.allocations(), 0u);
  EXPECT_EQ(guard.releases(), 0u);
  EXPECT_GT(sum, 0.0);
}

TEST(AllocationGuard, CountsOnlyItsOwnThread) {
  std::thread other;
  std::uint64_t seen_here = 1;
  std::uint64_t seen_there = 0;
  const std::function<void()> work = [&] {
    const AllocationGuard guard;
    for (int i = 0; i < 1000; ++i) delete escape(new int(i));
    seen_there = guard.allocations();
  };
  other = std::thread(std::cref(work));
  {
    const AllocationGuard guard;
    other.join();
    seen_here = guard.allocations();
  }
  EXPECT_EQ(seen_here, 0u);
  EXPECT_EQ(seen_there, 1000u);
}

}  // namespace
