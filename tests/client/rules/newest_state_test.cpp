/// Which state is the newest, and which one the user has.

#include "newest_state.hpp"

#include <gtest/gtest.h>

namespace haptic::client {
namespace {

DeviceState state(std::uint64_t seq) {
  return {.seq = seq, .x_probe = {static_cast<double>(seq)}};
}

TEST(NewestState, AnOlderStateIsDropped) {
  NewestState states;
  EXPECT_TRUE(states.take(state(5)));
  EXPECT_FALSE(states.take(state(5)));
  EXPECT_FALSE(states.take(state(4)));
  EXPECT_EQ(states.newest().seq, 5U);
}

TEST(NewestState, EachStateIsCalledBackOnce) {
  NewestState states;
  EXPECT_FALSE(states.to_call_back()) << "none came yet";
  states.take(state(1));
  states.take(state(2));
  EXPECT_TRUE(states.to_call_back());
  EXPECT_FALSE(states.to_call_back());
}

TEST(NewestState, AWaitReturnsEachStateOnce) {
  NewestState states;
  EXPECT_FALSE(states.to_return());
  states.take(state(1));
  EXPECT_EQ(states.give().seq, 1U);
  EXPECT_TRUE(states.to_return()) << "a look at it is no wait";
  EXPECT_EQ(states.give_to_waiting().seq, 1U);
  EXPECT_FALSE(states.to_return());
}

TEST(NewestState, TheUserKeepsTheGivenState) {
  NewestState states;
  states.take(state(1));
  static_cast<void>(states.give());
  states.take(state(2));
  EXPECT_EQ(states.given().seq, 1U);
  EXPECT_EQ(states.given().x_probe, std::vector<double>{1.0});
}

TEST(NewestState, AnotherSessionCountsFromTheBeginning) {
  NewestState states;
  states.take(state(100));
  static_cast<void>(states.give_to_waiting());
  states.restart();
  EXPECT_EQ(states.newest().seq, 0U);
  EXPECT_EQ(states.given().seq, 0U);
  EXPECT_TRUE(states.take(state(1)));
  EXPECT_TRUE(states.to_return());
}

}  // namespace
}  // namespace haptic::client
