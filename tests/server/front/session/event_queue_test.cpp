#include "server/front/session/front.hpp"

#include <gtest/gtest.h>

namespace haptic::server {
namespace {

TEST(EventQueue, DropsStalenessFirstAndCountsIt) {
  EventQueue queue;
  DeviceEvent fault{.kind = DeviceEvent::Kind::kFault, .reason = "DEVICE_LOST"};
  DeviceEvent staleness{.kind = DeviceEvent::Kind::kStaleness};
  queue.push(fault);
  for (std::size_t i = 0; i < EventQueue::kCapacity + 9; ++i) queue.push(staleness);
  const auto first = queue.pop();
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->reason, "DEVICE_LOST");
  EXPECT_NE(first->message.view().find("10 older events"), std::string::npos);
  std::size_t rest = 0;
  while (queue.pop()) ++rest;
  EXPECT_EQ(rest, EventQueue::kCapacity - 1);
}

}  // namespace
}  // namespace haptic::server
