// The owner's pages, tick by tick.
#include "server/owner/link/publisher.hpp"

#include <gtest/gtest.h>

#include "tests/server/support/device_rig.hpp"

namespace haptic::test {
namespace {

using server::DeviceStatus;
using server::OwnersPages;
using server::Publisher;

class PublisherTest : public testing::Test {
 protected:
  PublisherTest() { rig.owner->connect(publisher); }
  /// A status that came since the last call.
  bool newer() { return pages.devices[0].status.newer(seen, status); }

  DeviceRig rig{};
  const std::shared_ptr<Publisher> publisher =
      std::make_shared<Publisher>(*rig.owner, [](const server::Answer&) {});
  const server::SharedMemory memory{publisher->memory().for_reader(), OwnersPages::bytes(1)};
  const OwnersPages& pages = *static_cast<const OwnersPages*>(memory.data());
  std::uint64_t seen{0};
  DeviceStatus status{};
};

TEST_F(PublisherTest, RepeatsAStatusNowAndThen) {
  rig.tick(100);
  static_cast<void>(newer());
  int told = 0;
  for (int i = 0; i < 1000; ++i) {
    rig.tick();
    if (newer()) ++told;
  }
  EXPECT_EQ(told, 1000ms / Publisher::kStatusEvery);
  EXPECT_LE(rig.now - status.ticked, Publisher::kStatusEvery) << "a loop that ticks is seen to";
}

TEST_F(PublisherTest, TellsAChangeInItsTick) {
  rig.control("s1", "alice");
  ASSERT_TRUE(newer());
  EXPECT_EQ(status.controller, "alice");
  rig.tick(10);
  rig.device->lost = true;
  for (int i = 0; i < 400 && rig.state() != core::LifecycleState::kFault; ++i) rig.tick();
  ASSERT_TRUE(newer());
  EXPECT_EQ(status.state, core::LifecycleState::kFault);
  EXPECT_TRUE(status.faults.has(core::Fault::kDeviceLost));
}

}  // namespace
}  // namespace haptic::test
