#include <gtest/gtest.h>

#include <cmath>

#include "server/session/device_event.hpp"

namespace haptic::server {
namespace {

using namespace std::chrono_literals;

/// The events of one record with these limiters at actuator 1 of two, `at` after the start.
std::vector<DeviceEvent> step(EventDetector& detector, core::Duration at,
                              std::initializer_list<core::Limiter> limiters) {
  core::TickRecord record;
  record.input.now = core::TimePoint(1h) + at;
  record.life.state = core::LifecycleState::kInit;
  record.effort.tau_a = (core::VecA(2) << 1.0, 7.5).finished();
  record.effort.temperature_c = (core::VecA(2) << std::nan(""), 93.4).finished();
  for (const core::Limiter limiter : limiters) {
    record.effort.limiters.set(limiter);
    record.effort.actuator_limiters[1].set(limiter);
  }
  std::vector<DeviceEvent> events;
  detector.step(record, "", events);
  return events;
}

TEST(LimiterEvent, BeginningLimitNamesTheActuator) {
  EventDetector detector;
  EXPECT_TRUE(step(detector, 0ms, {}).empty());
  const auto events = step(detector, 1ms, {core::Limiter::kPower});
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, DeviceEvent::Kind::kLimiter);
  EXPECT_EQ(events[0].reason, "POWER");
  EXPECT_EQ(events[0].message, "a limit holds actuator 1 at 7.5");
}

TEST(LimiterEvent, TemperatureLimitTellsItsValue) {
  EventDetector detector;
  const auto events = step(detector, 0ms, {core::Limiter::kTemperature});
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].message, "a limit holds actuator 1 at 7.5 and 93 C");
}

TEST(LimiterEvent, FlickeringLimitIsOneEvent) {
  EventDetector detector;
  int count = 0;
  for (int ms = 0; ms < 5000; ++ms) {
    const bool acts = ms % 7 < 3;
    count += static_cast<int>(
        (acts ? step(detector, ms * 1ms, {core::Limiter::kRate}) : step(detector, ms * 1ms, {}))
            .size());
  }
  EXPECT_EQ(count, 1);
  EXPECT_EQ(step(detector, 7s, {core::Limiter::kRate}).size(), 1u) << "after a second without";
}

TEST(LimiterEvent, ProxyLimitsAreNoEvent) {
  EventDetector detector;
  EXPECT_TRUE(
      step(detector, 0ms,
           {core::Limiter::kDirectionGuard, core::Limiter::kEnvelope, core::Limiter::kEnergyTank})
          .empty());
}

}  // namespace
}  // namespace haptic::server
