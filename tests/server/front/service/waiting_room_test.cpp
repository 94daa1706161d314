#include "server/front/service/service_context.hpp"

#include <gtest/gtest.h>

#include "server/front/service/service_context.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;
using core::TimePoint;
using server::WaitingRoom;

class Guest final : public server::OpenStream {
 public:
  using OpenStream::OpenStream;
  void server_closes() override {}
};

class WaitingRoomTest : public testing::Test {
 protected:
  [[nodiscard]] std::shared_ptr<Guest> guest() { return std::make_shared<Guest>(streams); }
  server::OpenStreams streams;
  WaitingRoom room{2, 5s};
  const TimePoint now{10s};
};

TEST_F(WaitingRoomTest, LongestWaitingMakesRoom) {
  const auto a = guest(), b = guest(), c = guest(), d = guest();
  EXPECT_EQ(room.enter(a, now), nullptr);
  EXPECT_EQ(room.enter(b, now), nullptr);
  EXPECT_EQ(room.enter(c, now), a);
  EXPECT_EQ(room.waiting(), 2U);
  EXPECT_FALSE(room.leave(*a));  // its place is gone
  EXPECT_TRUE(room.leave(*b));
  EXPECT_EQ(room.enter(d, now), nullptr);
  EXPECT_EQ(room.enter(a, now), c);
}

TEST_F(WaitingRoomTest, EndsOverdueWaits) {
  const auto a = guest(), b = guest();
  static_cast<void>(room.enter(a, now));
  static_cast<void>(room.enter(b, now + 1ms));
  EXPECT_TRUE(room.overdue(now + 4999ms).empty());
  EXPECT_EQ(room.overdue(now + 5s), std::vector<std::shared_ptr<server::OpenStream>>{a});
  EXPECT_TRUE(room.leave(*b));
  EXPECT_TRUE(room.overdue(now + 1h).empty());
  EXPECT_EQ(room.waiting(), 0U);
}

TEST_F(WaitingRoomTest, LeaverIsNotCalled) {
  auto a = guest();
  static_cast<void>(room.enter(a, now));
  a.reset();
  EXPECT_TRUE(room.overdue(now + 5s).empty());
}

}  // namespace
}  // namespace haptic::test
