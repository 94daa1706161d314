#include "server/owner/state/state_message.hpp"

#include <gtest/gtest.h>

#include "haptic/schema/fields.hpp"
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
  r.input.device.sample.q = VecQ::Constant(2, 9.0);
  r.input.device.sample.tau_measured = VecA::Ones(1);
  r.sensed.q = r.effort.q_star = VecQ::Ones(2);
  r.sensed.refused = true;
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
  core::TickRecord tracked;
  tracked.sensed.tracker = {true, 0, 1, core::Staleness::kFresh, std::chrono::milliseconds(1)};
  tracked.sensed.q = VecQ::Zero(6);
  v1::DeviceState state, full;
  write({tracked}, state);
  write({full_record(), Carrier::kUdp, 1}, full);
  state.MergeFrom(full);
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
  const core::TickRecord none;
  v1::DeviceState state, fresh;
  write({full_record(), Carrier::kUdp, 1}, state);
  write({none}, state);
  write({none}, fresh);
  EXPECT_EQ(state.SerializeAsString(), fresh.SerializeAsString());
}

TEST(StateMessage, SaysWhatTheRecordSays) {
  core::TickRecord r = full_record();
  r.beat.tick = 77;
  r.input.now = core::TimePoint(std::chrono::seconds(3));
  r.life.gain = 0.5;
  r.proxy.age = std::chrono::nanoseconds(3999);
  r.anchor.active_planes = 5;
  r.effort.passivity.tank = 0.003;
  v1::DeviceState state;
  write({r, Carrier::kUdp, 7}, state);
  EXPECT_EQ(state.seq(), 77U);
  EXPECT_EQ(state.server_time_ns(), 3'000'000'000);
  EXPECT_EQ(state.state(), v1::DEVICE_STATE_NAME_ENGAGED);
  EXPECT_EQ(state.transport(), v1::TRANSPORT_UDP);
  EXPECT_EQ(state.lease_epoch(), 7U);
  EXPECT_EQ(state.proxy_age_us(), 3U);
  EXPECT_EQ(state.active_planes(), 5U);
  EXPECT_EQ(state.passivity().tank(), 0.003);
  EXPECT_EQ(state.stiffness_in_effect(0), 40.0) << "half of what derating leaves";
  EXPECT_EQ(state.reading(0), 9.0);
  r.derating.reason = core::DeratingReason::kNone;
  r.sensed.refused = false;
  r.effort.passivity.on = false;
  write({r}, state);
  EXPECT_EQ(state.stiffness_in_effect(0), 50.0) << "half of the settings'";
  EXPECT_EQ(state.reading_size(), 0) << "it was not refused";
  EXPECT_FALSE(state.has_passivity());
}

TEST(StateMessage, CrossesWithWhatAFrontNeeds) {
  const core::TickRecord r = full_record();
  v1::DeviceState state, crossed;
  write({r}, state);
  SerialisedState serialised;
  serialise(r, state, serialised);
  EXPECT_EQ(serialised.tick, 1U);
  EXPECT_EQ(serialised.now, r.input.now);
  EXPECT_TRUE(serialised.proxy_used);
  EXPECT_EQ(serialised.proxy_age, r.proxy.age);
  const auto bytes = serialised.message();
  ASSERT_TRUE(crossed.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())));
  EXPECT_EQ(crossed.SerializeAsString(), state.SerializeAsString());
}

}  // namespace
}  // namespace haptic::server
