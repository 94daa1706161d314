/// The row of tests/relay/README.md#rows about watchers, on virtual time: through the shipped
/// broadcaster and its budget.

#include <gtest/gtest.h>

#include <array>
#include <memory>

#include "server/front/session/pace.hpp"
#include "tests/relay/matrix_table.hpp"
#include "tests/relay/virtual_world.hpp"
#include "tests/server/support/broadcast.hpp"

namespace haptic::test {
namespace {

/// A stream that wants every state.
class Observer final : public server::Subscriber {
 public:
  bool offer(const server::SerialisedState& state, server::StateFrame&, bool allowed) override {
    if (!allowed || !pace.due(state.tick)) return false;
    pace.sent(state.tick);
    ++sent;
    return true;
  }
  server::Pace pace{1000.0, 0.0};
  std::uint64_t sent{0};
};

TEST(VirtualClient, SixteenObserversAreNotFelt) {
  MatrixRow row("virtual/16_observers",
                "force identical to the bit to that without observers; the controller gets every "
                "state, the observers what is left, in equal parts, and what they miss is counted");
  VirtualWorld alone(shipped_scenario("jitter_5ms")), watched(shipped_scenario("jitter_5ms"));
  const auto broadcast = Broadcast::of(*watched.rig.owner, 8000.0);
  server::Broadcaster& broadcaster = broadcast->broadcaster;
  const auto controller = std::make_shared<Observer>();
  broadcaster.add(controller, watched.lease.tenure);
  std::array<std::shared_ptr<Observer>, 16> observers;
  for (auto& observer : observers) {
    observer = std::make_shared<Observer>();
    broadcaster.add(observer);
  }
  while (alone.time() < 3s) {
    alone.step();
    watched.step();
    ASSERT_EQ(alone.force(), watched.force());
    ASSERT_EQ(alone.rig.newest().proxy.age, watched.rig.newest().proxy.age);
  }
  ASSERT_EQ(watched.rig.state(), core::LifecycleState::kEngaged);
  EXPECT_EQ(controller->sent, 3000U);
  for (const auto& observer : observers) {  // 8000 states per second for 16 that want 1000 each
    EXPECT_NEAR(static_cast<double>(observer->sent), 1500.0, 10.0);
    EXPECT_NEAR(static_cast<double>(observer->pace.conflated()), 1500.0, 10.0);
    broadcaster.remove(observer.get());
  }
  broadcaster.remove(controller.get());
  row.got("3000 states to the controller, " + std::to_string(observers[0]->sent) +
          " to an observer");
}

}  // namespace
}  // namespace haptic::test
