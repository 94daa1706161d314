// Who gets which state, on virtual time.
#include "server/front/service/broadcaster.hpp"

#include <gtest/gtest.h>

#include "server/front/session/pace.hpp"
#include "tests/server/support/device_rig.hpp"

namespace haptic::test {
namespace {

class Counter final : public server::Subscriber {
 public:
  bool offer(const server::SerialisedState& state, server::StateFrame&, bool allowed) override {
    ++asked;
    if (!allowed || !pace.due(state.tick)) return false;
    pace.sent(state.tick);
    ++sent;
    return true;
  }
  server::Pace pace{1000.0, 0.0};
  int asked{0};
  int sent{0};
};

class BroadcasterTest : public testing::Test {
 protected:
  /// epoch 0: a watcher.
  std::shared_ptr<Counter> join(std::uint32_t epoch = 0) {
    auto counter = std::make_shared<Counter>();
    broadcaster->add(counter, epoch);
    return counter;
  }
  void SetUp() override { rig.owner->connect(broadcaster); }
  DeviceRig rig;
  std::shared_ptr<server::Broadcaster> broadcaster =
      std::make_shared<server::Broadcaster>(0, server::WatchBudget(500.0));
};

TEST_F(BroadcasterTest, ControllerGetsEveryTick) {
  const auto controller = join(rig.control().epoch);
  for (int i = 0; i < 16; ++i) join();
  rig.stream(1000, 0.0);
  EXPECT_EQ(controller->sent, 1000);
}

TEST_F(BroadcasterTest, FormerControllerBecomesAWatcher) {
  const auto controller = join(rig.control().epoch);
  std::vector<std::shared_ptr<Counter>> watchers;
  for (int i = 0; i < 4; ++i) watchers.push_back(join());
  rig.tick(5000);  // 2 s of silence end the lease
  ASSERT_FALSE(rig.sessions->holds_lease("s1"));
  const int before = controller->sent;
  rig.tick(5000);
  EXPECT_NEAR(controller->sent - before, 500, 5);
  EXPECT_GT(watchers[0]->sent, 500);
}

TEST_F(BroadcasterTest, WatchersShareTheBudgetFairly) {
  std::vector<std::shared_ptr<Counter>> watchers;
  for (int i = 0; i < 4; ++i) watchers.push_back(join());
  rig.tick(4000);  // 4 s at 500 states/s, for four who want 1000 each
  int total = 0;
  for (const auto& watcher : watchers) {
    EXPECT_NEAR(watcher->sent, 500, 5);
    EXPECT_NEAR(static_cast<double>(watcher->pace.conflated()), 3500.0, 10.0);
    EXPECT_EQ(watcher->asked, 4000);  // events go through even where states do not
    total += watcher->sent;
  }
  EXPECT_NEAR(total, 2000, 5);
}

TEST_F(BroadcasterTest, WatchersWithinBudgetMissNothing) {
  const auto watcher = join();
  watcher->pace = server::Pace(1000.0, 400.0);
  rig.tick(1000);
  EXPECT_EQ(watcher->sent, 400);
  EXPECT_EQ(watcher->pace.conflated(), 0U);
}

TEST_F(BroadcasterTest, FormerWatcherIsNotAskedAgain) {
  const auto watcher = join();
  rig.tick(10);
  broadcaster->remove(watcher.get());
  rig.tick(10);
  EXPECT_EQ(watcher->asked, 10);
}

}  // namespace
}  // namespace haptic::test
