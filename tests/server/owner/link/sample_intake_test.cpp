#include "server/owner/link/sample_intake.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <memory>

#include "server/owner/link/front_requests.hpp"
#include "tests/server/support/device_rig.hpp"
#include "tests/support/allocation_guard.hpp"

namespace haptic::test {
namespace {

using server::Carrier;
using server::IngressVerdict;
using server::ProxySample;
using server::SampleIntake;
using server::SampleKind;
using server::StopAhead;

class IntakeTest : public testing::Test {
 protected:
  void SetUp() override {
    rig.control();
    rig.tick(20);
  }
  ProxySample sample(double a) {
    return {.epoch = rig.epoch,
            .seq = ++rig.seq,
            .arrival = rig.now,
            .mode = core::ProxyMode::kHeld,
            .position = {a, 0.0}};
  }
  template <typename T>
  void send(SampleKind kind, const T& value) {
    ASSERT_TRUE(send_sample(front.its_samples.get(), kind, value));
  }
  void push(int samples) {
    for (int i = 0; i < samples; ++i) send(SampleKind::kProxy, sample(0.01));
  }
  std::uint64_t used() {
    rig.tick();
    return rig.newest().proxy.seq;
  }
  DeviceRig rig{};
  server::Publisher publisher{*rig.owner, {}};
  SampleIntake intake{*rig.owner, publisher};
  server::FrontProcess front{1, {}};
};

TEST_F(IntakeTest, ALongQueueTakesSeveralTurns) {
  push(SampleIntake::kPerTurn + 1);
  EXPECT_TRUE(intake.take(front));
  EXPECT_EQ(used(), static_cast<unsigned>(SampleIntake::kPerTurn));
  EXPECT_TRUE(intake.take(front));
  EXPECT_EQ(used(), static_cast<unsigned>(SampleIntake::kPerTurn) + 1);
}

TEST_F(IntakeTest, NoVerdictAllocates) {
  std::vector<ProxySample> samples(9, sample(0.01));
  samples[1].epoch = 77;
  samples[2].mode = core::ProxyMode::kNone;
  samples[3].position.count = 1;
  samples[4].position.value[1] = std::numeric_limits<double>::quiet_NaN();
  samples[5].position.value[0] = -1e300;
  samples[6].plane_count = 1;
  samples[7].mode = core::ProxyMode::kPlanes;
  samples[7].plane_count = 1;
  samples[7].planes[0] = {{1.0, std::numeric_limits<double>::infinity()}, 1e300};
  samples[8].seq = 0;
  for (const ProxySample& one : samples) {
    send(SampleKind::kProxy, one);
    const AllocationGuard guard;
    EXPECT_TRUE(intake.take(front));
    EXPECT_EQ(guard.allocations(), 0U);
    EXPECT_EQ(guard.releases(), 0U);
  }
  const auto& counters = rig.sessions->status().samples;
  EXPECT_EQ(counters[IngressVerdict::kAccepted], 1U);
  EXPECT_EQ(counters[IngressVerdict::kBadPlane], 2U);
}

TEST_F(IntakeTest, AnotherDevicesNumberIsNobodys) {
  ProxySample odd = sample(0.01);
  odd.device = 1;
  send(SampleKind::kProxy, odd);
  send(SampleKind::kStopAhead, StopAhead{1, "why"});
  push(1);
  EXPECT_TRUE(intake.take(front));
  EXPECT_EQ(used(), 2U);
  EXPECT_TRUE(front.stops.empty());
}

TEST_F(IntakeTest, AStopWaitsForNoRequest) {
  server::FrontRequests requests(*rig.owner, publisher);
  rig.owner->connect(std::shared_ptr<server::Publisher>(&publisher, [](auto*) {}));
  push(1);
  send(SampleKind::kStopAhead, StopAhead{0, "hot"});
  EXPECT_TRUE(intake.take(front));
  requests.take_stops(front, rig.now);
  EXPECT_TRUE(front.stops.empty());
  // A second one while the first is under way is kept until that is answered.
  send(SampleKind::kStopAhead, StopAhead{0, "hotter"});
  EXPECT_TRUE(intake.take(front));
  requests.take_stops(front, rig.now);
  EXPECT_EQ(front.stops.size(), 1U);
  rig.tick();
  EXPECT_EQ(rig.state(), core::LifecycleState::kFault);
}

TEST_F(IntakeTest, WhatNoFrontSendsEndsIt) {
  const std::uint64_t unknown = 77;
  EXPECT_TRUE(server::send_bytes(front.its_samples.get(), server::bytes_of(unknown)));
  EXPECT_FALSE(intake.take(front));
  const int descriptor = front.its_link.get();
  EXPECT_TRUE(server::send(front.its_samples.get(), unknown, std::span(&descriptor, 1)));
  EXPECT_FALSE(intake.take(front)) << "descriptors";
}

}  // namespace
}  // namespace haptic::test
