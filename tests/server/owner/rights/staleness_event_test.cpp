/// Events of staleness (proto/README.md#staleness-and-gain): one per change of level, at the age at
/// which the level changes.

#include <gtest/gtest.h>

#include "tests/server/support/device_rig.hpp"

namespace haptic::test {
namespace {

using server::DeviceEvent;
using server::EventDetector;

struct Change {
  std::string reason{};
  core::Duration age{};  ///< of the newest sample when it was told
};

/// The staleness events that wait, by their distance from `last_sample`.
std::vector<Change> changes(server::EventQueue& queue, core::TimePoint last_sample) {
  std::vector<Change> all;
  while (const auto event = queue.pop()) {
    if (event->kind != DeviceEvent::Kind::kStaleness) continue;
    all.push_back({event->reason.str(), event->time - last_sample});
  }
  return all;
}

class StalenessEvent : public testing::Test {
 protected:
  StalenessEvent() {
    rig.tick(3);
    rig.control();
    rig.press();
    queue = rig.sessions->subscribe("s1");
    rig.publish(0.01);
    last_sample = rig.now;
  }

  DeviceRig rig;
  std::shared_ptr<server::EventQueue> queue;
  core::TimePoint last_sample{};
};

TEST_F(StalenessEvent, EachLevelIsReportedOnce) {
  rig.tick(400);
  const auto told = changes(*queue, last_sample);
  // A client of 1 kHz is fresh for 5 ms (2.5 periods, but at least that), holds to 100 and fades to
  // 180.
  const std::vector<Change> expected = {
      {"FRESH -> HOLD", 5ms}, {"HOLD -> FADE", 100ms}, {"FADE -> LOST", 180ms}};
  ASSERT_EQ(told.size(), expected.size());
  for (std::size_t i = 0; i < told.size(); ++i) {
    EXPECT_EQ(told[i].reason, expected[i].reason);
    // Events of one tick are told a nanosecond apart.
    EXPECT_EQ(std::chrono::floor<std::chrono::microseconds>(told[i].age), expected[i].age)
        << told[i].reason;
  }
}

/// A client that missed some names the last one that it knows by its time.
TEST_F(StalenessEvent, NoTwoEventsShareATime) {
  rig.tick(400);
  core::TimePoint last{};
  int several = 0;
  while (const auto event = queue->pop()) {
    EXPECT_GT(event->time, last) << event->reason.view();
    several += event->time - last < 1us ? 1 : 0;
    last = event->time;
  }
  EXPECT_GT(several, 0) << "LOST and the end of force come in one tick";
}

TEST_F(StalenessEvent, FirstSampleAfterSilenceIsReported) {
  rig.tick(50);
  rig.stream(20, 0.01);
  const auto told = changes(*queue, last_sample);
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[0].reason, "FRESH -> HOLD");
  EXPECT_EQ(told[1].reason, "HOLD -> FRESH");
}

TEST_F(StalenessEvent, NewLeaseReportsNoOldProxy) {
  EventDetector detector;
  core::TickRecord record;
  record.proxy.level = core::Staleness::kHold;
  std::vector<DeviceEvent> events;
  detector.step(record, "", events);
  record.proxy.level = core::Staleness::kLost;
  detector.step(record, "", events);
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events.back().reason, "HOLD -> LOST");
  EXPECT_EQ(events.back().message, "there is no proxy");
}

}  // namespace
}  // namespace haptic::test
