#include "server/owner/link/turn_watch.hpp"

#include <gtest/gtest.h>

#include "tests/support/within.hpp"

namespace haptic::server {
namespace {

TEST(TurnWatch, SaysThatAThreadIsStuck) {
  std::atomic<int> stuck{0};
  TurnWatch watch([&] { ++stuck; }, std::chrono::milliseconds(5));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(stuck.load(), 0) << "it has not begun";
  watch.turned();
  EXPECT_TRUE(test::eventually([&] { return stuck.load() >= 2; }));
  watch.end();
}

TEST(TurnWatch, IsContentWithTurns) {
  std::atomic<int> stuck{0};
  TurnWatch watch([&] { ++stuck; }, std::chrono::milliseconds(20));
  for (int i = 0; i < 100; ++i) {
    watch.turned();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(stuck.load(), 0);
}

}  // namespace
}  // namespace haptic::server
