/// read() and write() of every device belong to the real-time loop: they never allocate.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/linear.hpp"
#include "hw/replay/replay.hpp"
#include "hw/simulated/hand.hpp"
#include "hw/simulated/linear.hpp"
#include "tests/hw/simulated/one_finger.hpp"
#include "tests/hw/virtual_loop.hpp"
#include "tests/support/allocation_guard.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::hw {
namespace {

using namespace std::chrono_literals;

/// Allocations and releases of 3 s with changing force, arming and a jump of the clock.
std::uint64_t heap_calls(Device& device) {
  test::VirtualLoop loop(device);
  const test::AllocationGuard guard;
  for (int i = 0; i < 3000; ++i) {
    if (i % 500 < 400) {
      loop.push(50.0 * std::sin(0.02 * i));
    } else {
      loop.disarm();
    }
    loop.set_period(i == 1500 ? core::Duration(10s) : core::Duration(1ms));
    loop.tick();
  }
  return guard.allocations() + guard.releases();
}

TEST(RealTime, ASimulatedFingerNeverAllocates) {
  SimulatedHandConfig config;
  config.motion_file = HAPTIC_SOURCE_DIR "/server/scenes/motion/reach_and_grasp.csv";
  config.noise_l_x = 1e-5;
  config.finger.actuator_friction = 2.0;
  const auto device = config.open(core::make_finger_exoskeleton(core::finger_sign_change()), {});
  EXPECT_EQ(heap_calls(*device), 0u);
}

TEST(RealTime, ASimulatedHandNeverAllocates) {
  const test::TemporaryFile file(
      "time_s,palm.x,palm.y,palm.z,palm.qx,palm.qy,palm.qz,palm.qw,index.q_o1_mcp_rad,"
      "index.q_o2_pip_rad\n0,0,0,0,0,0,0,1,0.2,0.3\n0.5,0.1,0,0,0,1,0,0,-0.6,0.3\n"
      "1,0,0.1,0,0,1,0,-0.1,0.5,0.6\n");
  SimulatedHandConfig config;
  config.fingers = 5;
  config.motion_file = file.path();
  config.noise_l_x = 1e-5;
  config.finger.actuator_friction = 2.0;
  const auto device = config.open(test::hand_on_a_palm(), {});
  EXPECT_EQ(heap_calls(*device), 0u);
}

TEST(RealTime, MassesNeverAllocate) {
  core::LinearMap map{.dofs = {{"z", core::Unit::kMetre, true, -0.1, 0.1}},
                      .coordinates = {{"z"}},
                      .A = core::MatXQ::Identity(1, 1),
                      .x_0 = core::VecX::Zero(1)};
  SimulatedLinearConfig config;
  config.mass = core::VecQ::Ones(1);
  config.max_effort = core::VecA::Constant(1, 20.0);
  const auto device = config.open(core::make_linear(map), {});
  EXPECT_EQ(heap_calls(*device), 0u);
}

TEST(RealTime, AReplayNeverAllocates) {
  const test::TemporaryFile file(
      "time_s,q_o1_mcp_rad,q_o2_pip_rad\n0,0.2,0.3\n0.04,-0.6,0.3\n0.08,0.5,0.6\n0.5,0.4,0.4\n"
      "0.52,0.5,0.4\n");
  ReplayConfig config;
  config.file = file.path();
  config.repeat = true;
  config.max_effort = core::VecA::Constant(1, 40.0);
  const auto device = config.open(core::make_finger_exoskeleton(core::finger_sign_change()), {});
  EXPECT_EQ(heap_calls(*device), 0u);
}

}  // namespace
}  // namespace haptic::hw
