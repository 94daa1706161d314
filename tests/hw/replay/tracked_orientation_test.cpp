#include "hw/replay/tracked_orientation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "haptic/core/error.hpp"
#include "haptic/core/model/serial_chain.hpp"
#include "hw/replay/replay.hpp"
#include "tests/hw/virtual_loop.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/message_of.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::hw {
namespace {

using test::TemporaryFile;
using test::VirtualLoop;
using testing::HasSubstr;

/// A joint on a tracked palm.
std::shared_ptr<const core::Kinematics> palm() {
  core::SerialChainParameters chain{.palm = core::TrackedPalm{}};
  chain.joints.push_back({"a"});
  chain.outputs = {{"tip", "", core::OutputKind::kFrame, {{0.1, 0, 0}, {}}}};
  return core::make_serial_chain(chain);
}

ReplayConfig playing_palm(const TemporaryFile& file) {
  ReplayConfig config;
  config.file = file.path();
  config.max_effort = core::VecA::Constant(1, 1.0);
  return config;
}

constexpr const char* kHeader = "time_s,palm.x,palm.y,palm.z,palm.qx,palm.qy,palm.qz,palm.qw,a\n";

/// The palm turns about an axis of its own by 1 rad/s, at 50 Hz; signs and lengths as they come.
std::string turning(const Eigen::Vector3d& axis, double from, int rows) {
  std::ostringstream csv;
  csv << std::setprecision(17) << kHeader;
  for (int i = 0; i < rows; ++i) {
    const double half = 0.5 * (from + 0.02 * i), length = i % 3 == 0 ? -1.0 : 1.5;
    const Eigen::Vector3d v = length * std::sin(half) * axis;
    csv << 0.02 * i << ",0.1,0.2,0.3," << v.x() << ',' << v.y() << ',' << v.z() << ','
        << length * std::cos(half) << ",0.5\n";
  }
  return csv.str();
}

TEST(TrackedOrientation, ATurnByPiIsSmooth) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 2) / 3.0;
  const TemporaryFile file(turning(axis, 2.5, 100));  // 2.5 to 4.48 rad
  const auto kinematics = palm();
  Replay device(playing_palm(file), kinematics);
  VirtualLoop loop(device);
  bool jumped = false;
  for (int ms = 0; ms <= 1980; ++ms) {
    const core::DeviceReading& reading = loop.tick();
    ASSERT_TRUE(reading.fresh);
    const Eigen::Vector3d phi = reading.sample.q.segment<3>(3);
    EXPECT_LE(phi.norm(), kPi + 1e-12);
    const double angle = 2.5 + 1e-3 * ms;
    // Compares the reading with the motion as rotations.
    const Eigen::Matrix3d R = Eigen::AngleAxisd(phi.norm(), phi.normalized()).toRotationMatrix();
    EXPECT_LT((R - Eigen::AngleAxisd(angle, axis).toRotationMatrix()).norm(), 1e-9) << ms;
    jumped = jumped || phi.dot(axis) < 0.0;
    EXPECT_NEAR(reading.sample.q[0], 0.1, 1e-15);
    EXPECT_NEAR(reading.sample.q[6], 0.5, 1e-15);
  }
  EXPECT_TRUE(jumped) << "the reading itself has gone to the other side";
}

TEST(TrackedOrientation, RotationVectorsAreAccepted) {
  const TemporaryFile file(
      "time_s,palm.rx,palm.ry,palm.rz,palm.x,palm.y,palm.z,a\n0,0.1,0.2,0.3,0,0,0,0\n"
      "0.02,0.1,0.2,0.3,0,0,0,0\n");
  Replay device(playing_palm(file), palm());
  VirtualLoop loop(device);
  EXPECT_LT((loop.tick().sample.q.segment<3>(3) - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-15);
}

TEST(TrackedOrientation, RefusesAZeroQuaternion) {
  const TemporaryFile file(std::string(kHeader) +
                           "0,0,0,0,0,0,0,1,0\n0.02,0,0,0,0,0,0,0,0\n0.04,0,0,0,0,0,0,1,0\n");
  EXPECT_THAT(
      test::message_of<core::DeviceError>([&] { return Replay(playing_palm(file), palm()); }),
      HasSubstr(":3: columns palm.qx .qy .qz .qw = 0, 0, 0, 0: must be a quaternion other than"));
}

}  // namespace
}  // namespace haptic::hw
