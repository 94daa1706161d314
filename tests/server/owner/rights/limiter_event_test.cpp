#include <gtest/gtest.h>

#include <cmath>

#include "server/owner/rights/device_event.hpp"

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
  const auto hot = step(detector, 2ms, {core::Limiter::kTemperature});
  ASSERT_EQ(hot.size(), 1u);
  EXPECT_EQ(hot[0].message, "a limit holds actuator 1 at 7.5 and 93 C");
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

TEST(LimiterEvent, ContactWithoutForceIsNamed) {
  EventDetector detector;
  const auto events = step(detector, 0ms, {core::Limiter::kNotFelt});
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].reason, "NOT_FELT");
  EXPECT_EQ(events[0].message,
            "this contact's direction is felt with 0 % of its depth: no motor moves the tool that "
            "way, or the scene's prior leaves it to joints without a motor");
}

TEST(LimiterEvent, AWaitIsToldOnce) {
  EventDetector detector;
  core::TickRecord record;
  record.life.state = core::LifecycleState::kInit;
  std::vector<DeviceEvent> events;
  const auto ask = [&](core::Duration at, core::EngageVerdict verdict) {
    record.input.now = core::TimePoint(1h) + at;
    record.life.engage = {record.life.engage.id + 1, verdict, 0, 3.0, 2.5};
    detector.step(record, "", events);
  };
  for (int i = 0; i < 9; ++i) ask(i * 50ms, core::EngageVerdict::kOutsideWindow);
  EXPECT_TRUE(events.empty()) << "a start takes a moment";
  for (int i = 9; i < 100; ++i) ask(i * 50ms, core::EngageVerdict::kOutsideWindow);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].reason, "OUTSIDE_WINDOW");
  EXPECT_EQ(events[0].message,
            "force waits: force on actuated DoF 0 would start at 3 (N or N m): at most 2.5 is "
            "allowed");
  ask(5s, core::EngageVerdict::kNeverFree);
  ask(5050ms, core::EngageVerdict::kOutsideWindow);
  EXPECT_EQ(events.size(), 2u) << "another reason";
  ask(5100ms, core::EngageVerdict::kAccepted);
  for (int i = 0; i < 20; ++i) ask(6s + i * 50ms, core::EngageVerdict::kOutsideWindow);
  EXPECT_EQ(events.size(), 3u) << "another wait";
}

TEST(LimiterEvent, DeratingTellsItsReason) {
  EventDetector detector;
  core::TickRecord record;
  record.input.settings.stiffness = (core::VecA(2) << 1500.0, 800.0).finished();
  std::vector<DeviceEvent> events;
  const auto step_at = [&](core::Duration at, double allowed) {
    record.input.now = core::TimePoint(1h) + at;
    record.derating = {};
    if (allowed < 1500.0) {
      record.derating = {core::DeratingReason::kHeld, 50ms, record.input.settings.stiffness,
                         (core::VecA(2) << allowed, 800.0).finished()};
    }
    events.clear();
    detector.step(record, "", events);
    return events.empty() ? std::string() : std::string(events[0].message.view());
  };
  static_cast<void>(step_at(0s, 1500.0));
  EXPECT_EQ(step_at(1s, 820.0), "stiffness of actuator 0: 1500 -> 820: proxy held, 50 ms old");
  EXPECT_EQ(events[0].kind, DeviceEvent::Kind::kLimiter);
  EXPECT_EQ(events[0].reason, "DERATED");
  EXPECT_EQ(step_at(3s, 700.0), "") << "about the same";
  EXPECT_EQ(step_at(4s, 600.0), "stiffness of actuator 0: 1500 -> 600: proxy held, 50 ms old");
  EXPECT_EQ(step_at(4500ms, 1500.0), "") << "once a second";
  EXPECT_EQ(step_at(6s, 1500.0), "the stiffness is that of the settings again");
  EXPECT_EQ(step_at(8s, 1500.0), "");
}

}  // namespace
}  // namespace haptic::server
