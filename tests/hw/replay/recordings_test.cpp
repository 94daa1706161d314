/// The recordings of people that live beside the checkout: every one of them replays, and what the
/// device reports of it is what an independent count finds.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <fstream>
#include <numbers>
#include <sstream>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/replay/replay.hpp"
#include "hw/simulated/finger.hpp"
#include "tests/hw/virtual_loop.hpp"

namespace haptic::hw {
namespace {

using namespace std::chrono_literals;
using Complex = std::complex<double>;

struct Row {
  double time, mcp, pip;
};

/// A plain reader of its own: no code in common with the device's.
std::vector<Row> rows_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  std::vector<Row> rows;
  while (std::getline(in, line)) {
    std::istringstream text(line);
    Row row{};
    char comma = 0;
    if (text >> row.time >> comma >> row.mcp >> comma >> row.pip) rows.push_back(row);
  }
  return rows;
}

double dot(Complex a, Complex b) {
  return a.real() * b.real() + a.imag() * b.imag();
}

/// Is (q1, q2) in reach? The loop equations of core/METHOD.md#finger-linkage by a scan: rod 1 gives
/// l for each angle t of the body link, rod 2's residual is followed over t and its roots bisected.
/// No closed form.
bool reachable(double q1, double q2) {
  const core::FingerDimensions dim = core::finger_sign_change();
  const Complex i(0.0, 1.0);
  const Complex e_a = std::exp(i * dim.rail_angle);
  const Complex P0(dim.rail_origin.x, dim.rail_origin.y);
  const Complex d(dim.body_d.x, dim.body_d.y), e(dim.body_e.x, dim.body_e.y);
  const Complex u1 = std::exp(-i * q1), n1 = i * u1;
  const Complex u2 = std::exp(-i * (q1 + q2)), n2 = i * u2;
  const auto l_at = [&](double t) {
    return (dim.rod1 - dot(n1, P0) - dot(n1, std::exp(i * t) * d)) / dot(n1, e_a);
  };
  const auto residual = [&](double t) {
    const Complex E = P0 + l_at(t) * e_a + std::exp(i * t) * e;
    return dot(n2, E - dim.proximal_phalanx * u1) - dim.rod2;
  };
  const auto allowed = [&](double t, double slope) {
    const double l = l_at(t);
    const double c1 = dot(u1, P0 + l * e_a + std::exp(i * t) * d);
    const double c2 = dot(u2, P0 + l * e_a + std::exp(i * t) * e - dim.proximal_phalanx * u1);
    // The assembly mode that the valid region has: det J > 0.
    return slope * dot(n1, e_a) > 0.0 && l >= dim.l_x_lower && l <= dim.l_x_upper &&
           c1 >= dim.slider1_lower && c1 <= dim.slider1_upper && c2 >= dim.slider2_lower &&
           c2 <= dim.slider2_upper;
  };
  constexpr int kScan = 4000;
  double before = dim.q_B_lower;
  for (int k = 1; k <= kScan; ++k) {
    const double after = dim.q_B_lower + (dim.q_B_upper - dim.q_B_lower) * k / kScan;
    if (residual(before) * residual(after) <= 0.0) {
      double low = before, high = after;
      for (int n = 0; n < 60; ++n) {
        const double middle = 0.5 * (low + high);
        (residual(low) * residual(middle) <= 0.0 ? high : low) = middle;
      }
      if (allowed(low, residual(after) - residual(before))) return true;
    }
    before = after;
  }
  return false;
}

class Recordings : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    file_ = std::filesystem::path(HAPTIC_SOURCE_DIR) / "../shared/data" / GetParam();
    if (!std::filesystem::exists(file_)) {
      GTEST_SKIP() << "no recordings of people beside this checkout";
    }
  }
  std::shared_ptr<const core::Kinematics> kinematics_ =
      core::make_finger_exoskeleton(core::finger_sign_change());
  std::filesystem::path file_;
};

TEST_P(Recordings, CountsMatchAnIndependentReader) {
  const std::vector<Row> rows = rows_of(file_);
  std::size_t outside = 0, gaps = 0;
  std::vector<bool> in_reach;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    in_reach.push_back(reachable(rows[i].mcp, rows[i].pip));
    outside += in_reach.back() ? 0 : 1;
    gaps += i > 0 && rows[i].time - rows[i - 1].time > 0.0500005 ? 1 : 0;
  }
  ReplayConfig config;
  config.file = file_;
  config.max_effort = core::VecA::Constant(1, 40.0);
  Replay device(config, kinematics_);
  EXPECT_EQ(device.facts().rows, rows.size());
  EXPECT_EQ(device.facts().replaced, outside);
  EXPECT_EQ(device.facts().gaps, gaps);
  EXPECT_NEAR(core::seconds(device.facts().length), rows.back().time - rows.front().time, 1e-8);
  RecordProperty("rows", static_cast<int>(rows.size()));
  RecordProperty("replaced", static_cast<int>(outside));
  RecordProperty("gaps", static_cast<int>(gaps));

  // At the time of every row the map gives the row's angles back, where they were in reach.
  core::DeviceReading reading;
  const core::TimePoint start(3s);
  core::VecX x(2);
  core::MatXQ J(2, 2);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    device.read(start + core::Duration(std::llround((rows[i].time - rows[0].time) * 1e9)), reading);
    ASSERT_TRUE(reading.fresh) << "row " << i;
    if (!in_reach[i]) continue;
    ASSERT_EQ(kinematics_->evaluate(reading.sample.q, x, J), core::MapStatus::kOk);
    EXPECT_NEAR(x[0], rows[i].mcp, 1e-9) << "row " << i;
    EXPECT_NEAR(x[1], rows[i].pip, 1e-9) << "row " << i;
  }
}

TEST_P(Recordings, AreSilentInGapsOnly) {
  const std::vector<Row> rows = rows_of(file_);
  ReplayConfig config;
  config.file = file_;
  config.max_effort = core::VecA::Constant(1, 40.0);
  Replay device(config, kinematics_);
  test::VirtualLoop loop(device);
  std::size_t row = 0;
  const double last = rows.back().time - rows.front().time;
  for (int ms = 0; 0.001 * ms < last; ++ms) {
    const double t = rows.front().time + 0.001 * ms;
    while (row + 1 < rows.size() && rows[row + 1].time <= t + 1e-9) ++row;
    const bool on_row = t - rows[row].time < 1e-9;
    const bool gap = !on_row && rows[row + 1].time - rows[row].time > 0.0500005;
    ASSERT_EQ(loop.tick().fresh, !gap) << t;
    for (int i = 0; i < 2; ++i) {
      ASSERT_GE(loop.reading().sample.q[i], device.info().limits.q_lower[i]);
      ASSERT_LE(loop.reading().sample.q[i], device.info().limits.q_upper[i]);
    }
  }
}

TEST_P(Recordings, MoveTheSimulatedFinger) {
  const std::vector<Row> rows = rows_of(file_);
  SimulatedFingerConfig config;
  config.motion_file = file_;
  SimulatedFinger device(config, kinematics_);
  test::VirtualLoop loop(device);
  double furthest = 0.0;
  for (int ms = 0; ms < 1500 + static_cast<int>(1000 * rows.back().time); ++ms) {
    ASSERT_TRUE(loop.tick().fresh);
    ASSERT_TRUE(loop.reading().sample.q.allFinite());
    furthest = std::max(furthest, device.physics().x().norm());
    const FingerEnergy& e = device.physics().energy();
    ASSERT_LE(device.physics().kinetic(), e.by_user + 1e-5) << "ms " << ms;
  }
  EXPECT_GT(furthest, 0.5);
}

INSTANTIATE_TEST_SUITE_P(OfPeople, Recordings,
                         testing::Values("dfki_pillow_grasps_100hz.csv", "leap_dropouts_74hz.csv",
                                         "leap_fist_selfocclusion_110hz.csv",
                                         "leap_grab_115hz.csv"),
                         [](const auto& recording) {
                           const std::string name = recording.param;
                           return name.substr(0, name.find('.'));
                         });

}  // namespace
}  // namespace haptic::hw
