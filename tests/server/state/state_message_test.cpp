#include "server/state/state_message.hpp"

#include <gtest/gtest.h>

#include "haptic/schema/fields.hpp"
#include "server/crossing/state_record.hpp"
#include "tests/server/support/device_rig.hpp"

namespace haptic::server {
namespace {

using core::VecA, core::VecQ, core::VecX;

/// Nothing in it is 0, empty or absent.
core::TickRecord full_record() {
  core::TickRecord r;
  r.beat.tick = 1;
  r.input.now = core::TimePoint(std::chrono::hours(1));
  r.input.settings.stiffness = VecA::Constant(1, 100.0);
  r.input.device.sample.q = VecQ::Constant(2, 9.0);  // refused: it is not q
  r.input.device.sample.tau_measured = VecA::Ones(1);
  r.sensed.q = r.effort.q_star = VecQ::Ones(2);
  r.sensed.q_a_dot = r.effort.tau_a = r.effort.tau_elastic = r.effort.drive =
      r.effort.temperature_c = r.effort.error_bound = VecA::Ones(1);
  r.anchor.x_probe = r.anchor.x = VecX::Ones(2);
  r.life.state = core::LifecycleState::kEngaged;
  r.proxy.mode = core::ProxyMode::kHeld;
  r.proxy.seq = 1;
  r.proxy.age = std::chrono::milliseconds(1);
  r.proxy.level = core::Staleness::kFresh;
  r.life.gain = 1.0;
  r.derating = {core::DeratingReason::kHeld, std::chrono::milliseconds(50), VecA::Constant(1, 80.0),
                VecA::Constant(1, 80.0)};
  r.anchor.projection = core::ProjectionStatus::kExact;
  r.anchor.condition = 1.0;
  r.anchor.active_planes = 1;
  r.anchor.unexplained = 0.25;
  r.life.faults.set(core::Fault::kLoopLate);
  r.effort.limiters.set(core::Limiter::kSlew);
  r.effort.actuator_limiters[0].set(core::Limiter::kSlew);
  r.effort.passivity.on = true;
  r.effort.passivity.tank = r.effort.passivity.storage = r.effort.passivity.scale = 1.0;
  r.effort.passivity.observed = r.effort.passivity.alpha = 1.0;
  return r;
}

TEST(StateMessage, SetsEveryField) {
  StateMessage message;
  core::TickRecord tracked;
  tracked.sensed.tracker = {true, 0, 1, core::Staleness::kFresh, std::chrono::milliseconds(1)};
  tracked.sensed.q = tracked.input.device.sample.q = VecQ::Zero(6);
  v1::DeviceState state = StateMessage().write(state_record(tracked));
  state.MergeFrom(message.write(state_record(full_record(), Carrier::kUdp, 1)));
  for (const schema::Leaf& leaf : schema::leaves(*v1::DeviceState::descriptor())) {
    const auto* const holder = schema::holder(state, leaf);
    ASSERT_NE(holder, nullptr) << leaf.name;
    const auto& reflection = *holder->GetReflection();
    EXPECT_TRUE(leaf.field->is_repeated() ? reflection.FieldSize(*holder, leaf.field) > 0
                                          : reflection.HasField(*holder, leaf.field))
        << leaf.name << " is not written";
  }
}

TEST(StateMessage, ForgetsTheRecordBefore) {
  StateMessage message;
  static_cast<void>(message.write(state_record(full_record(), Carrier::kUdp, 1)));
  EXPECT_EQ(message.write({}).SerializeAsString(), StateMessage().write({}).SerializeAsString());
}

}  // namespace
}  // namespace haptic::server
