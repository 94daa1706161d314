#include "server/owner/link/sample_intake.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <limits>
#include <memory>
#include <thread>

#include "tests/server/support/device_rig.hpp"
#include "tests/support/allocation_guard.hpp"

namespace haptic::test {
namespace {

using server::Carrier;
using server::IngressVerdict;
using server::ProxySample;
using server::SampleIntake;

class IntakeTest : public testing::Test {
 protected:
  void SetUp() override {
    rig.control();
    rig.tick(20);
    intake.serve(front.get());
  }
  ProxySample sample(double a) {
    return {.epoch = rig.epoch,
            .seq = ++rig.seq,
            .arrival = rig.now,
            .mode = core::ProxyMode::kHeld,
            .position = {a, 0.0}};
  }
  void push(int samples) {
    for (int i = 0; i < samples; ++i) front->proxies.push(sample(0.01));
  }
  std::uint64_t used() {
    rig.tick();
    return rig.newest().proxy.seq;
  }
  DeviceRig rig{};
  server::Publisher publisher{*rig.owner, {}};
  SampleIntake intake{*rig.owner, publisher};
  std::unique_ptr<server::FrontsPages> front = std::make_unique<server::FrontsPages>();
};

TEST_F(IntakeTest, ATickTakesAFew) {
  push(SampleIntake::kPerTick + 1);
  intake.take_for_tick();
  EXPECT_EQ(used(), static_cast<unsigned>(SampleIntake::kPerTick));
  EXPECT_FALSE(intake.take()) << "that was the last one";
  EXPECT_EQ(used(), static_cast<unsigned>(SampleIntake::kPerTick) + 1);
}

TEST_F(IntakeTest, ALongQueueTakesSeveralTurns) {
  push(SampleIntake::kPerTurn + 1);
  EXPECT_TRUE(intake.take());
  EXPECT_FALSE(intake.take());
  EXPECT_EQ(used(), static_cast<unsigned>(SampleIntake::kPerTurn) + 1);
}

TEST_F(IntakeTest, TheLoopWaitsForNobody) {
  push(1);
  {
    const auto turn = rig.owner->turn();
    std::thread loop([&] { intake.take_for_tick(); });
    loop.join();
  }
  EXPECT_EQ(used(), 0U);
  intake.take_for_tick();
  EXPECT_EQ(used(), 1U);
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
    front->proxies.push(one);
    const AllocationGuard guard;
    intake.take_for_tick();
    EXPECT_EQ(guard.allocations(), 0U);
    EXPECT_EQ(guard.releases(), 0U);
  }
  const auto& counters = rig.sessions->status().samples;
  EXPECT_EQ(counters[IngressVerdict::kAccepted], 1U);
  EXPECT_EQ(counters[IngressVerdict::kBadPlane], 2U);
}

TEST_F(IntakeTest, OnlyTheServingFrontIsHeard) {
  push(1);
  intake.serve(nullptr);
  intake.take_for_tick();
  EXPECT_FALSE(intake.take());
  EXPECT_EQ(used(), 0U);
}

// A front's pages go when it is replaced. The thread sanitizer sees a look that is too late.
TEST_F(IntakeTest, PagesMayGoWhileLoopTicks) {
  std::atomic<bool> end{false};
  std::thread loop([&] {
    while (!end.load()) intake.take_for_tick();
  });
  for (int i = 0; i < 500; ++i) {
    push(1);
    intake.serve(nullptr);
    front = std::make_unique<server::FrontsPages>();
    intake.serve(front.get());
  }
  end.store(true);
  loop.join();
  push(1);
  intake.take_for_tick();
  EXPECT_EQ(used(), rig.seq);
}

TEST_F(IntakeTest, AnotherDevicesNumberIsNobodys) {
  ProxySample odd = sample(0.01);
  odd.device = 1;
  front->proxies.push(odd);
  push(1);
  intake.take_for_tick();
  EXPECT_EQ(used(), 2U);
}

}  // namespace
}  // namespace haptic::test
