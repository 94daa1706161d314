/// A device whose samples cannot be its own says so in the log.

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <sstream>

#include "tests/server/support/device_rig.hpp"

namespace haptic::test {
namespace {

TEST(FirstSample, WrongSizeIsLoggedOnce) {
  std::ostringstream log;
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(std::make_shared<spdlog::logger>(
      "test", std::make_shared<spdlog::sinks::ostream_sink_st>(log)));
  DeviceRig rig;
  rig.device->q = core::VecQ::Zero(3);
  rig.tick(5);
  spdlog::set_default_logger(before);
  EXPECT_EQ(rig.state(), core::LifecycleState::kInit);
  const std::string text = log.str();
  const std::size_t first = text.find("q has 3 values, must have 2");
  EXPECT_NE(first, std::string::npos) << text;
  EXPECT_EQ(text.find("q has", first + 1), std::string::npos) << text;
}

}  // namespace
}  // namespace haptic::test
