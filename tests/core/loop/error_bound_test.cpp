// The bound of the felt force's error (core/METHOD.md#error-bound), on the real pipeline in virtual
// time: a hand moves a mass in and out of a soft object whose simulation is behind a network.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/rendering/renderer.hpp"
#include "tests/support/loop/pipeline_loop.hpp"
#include "tests/support/loop/rails.hpp"

namespace haptic::core::error_bound_test {
namespace {

using haptic::test::ClientSettings;
using haptic::test::PipelineLoop;

constexpr double kSpring = haptic::test::Rails::coupling, kObject = 500.0;  // N/m
constexpr double kTrueGamma = kSpring / kObject;
constexpr double kRounding = 1e-5;  // N

struct Judged {
  std::vector<double> errors{}, bounds{};  ///< in contact, N
  double peak{0.0};                        ///< N
  int unknown{0};                          ///< ticks, of all
  int broken{0};
};

ClientSettings telling_client(double round_trip_s, double told) {
  ClientSettings client;
  client.mode = ProxyMode::kPlanes;
  client.stop = VecX::Zero(1);
  client.compliance = kTrueGamma;
  client.told_compliance = told * kTrueGamma;
  client.delay_s = round_trip_s;
  client.lost = 0.1;
  return client;
}

Judged press(const ClientSettings& client, double tank = -1.0) {
  constexpr int kBegin = 1000, kTicks = kBegin + 8000;
  PipelineLoop loop(haptic::test::patient_rail(tank), client, haptic::test::Rails::damping);
  haptic::test::HandMasses mass(haptic::test::swinging(0.7, 0.018));
  Judged judged;
  for (int k = 1; k <= kTicks; ++k) {
    mass.step((k - kBegin) * 1e-3, loop.tau_a());
    const double q = mass.q()[0];
    if (k == kBegin - 400) loop.engage();
    const TickRecord& record = loop.tick(mass.q());
    if (k < kBegin) continue;
    const double shadow = q > 0.0 ? -kSpring * q / (1.0 + kTrueGamma) : 0.0;
    judged.peak = std::max(judged.peak, -shadow);
    if (record.effort.error_bound.size() == 0) {
      ++judged.unknown;
      continue;
    }
    const double error = std::abs(record.effort.tau_elastic[0] - record.life.gain * shadow);
    judged.broken += error > record.effort.error_bound[0] + kRounding ? 1 : 0;
    if (q <= 0.0) continue;
    judged.errors.push_back(error);
    judged.bounds.push_back(record.effort.error_bound[0]);
  }
  loop.require_engaged();
  return judged;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

TEST(ErrorBound, HoldsAtAnyDelay) {
  for (const double round_trip : {0.0, 0.020, 0.050, 0.100, 0.200}) {
    for (const double told : {0.8, 1.0, 1.2}) {
      SCOPED_TRACE(std::to_string(round_trip) + " s, told " + std::to_string(told));
      ClientSettings client = telling_client(round_trip, told);
      client.uncertainty = 0.2;
      const Judged judged = press(client);
      EXPECT_EQ(judged.broken, 0);
      EXPECT_EQ(judged.unknown, 0);
      if (told != 1.0 && round_trip > 0.0) {
        EXPECT_LT(median(judged.bounds), 5.0 * median(judged.errors));
      }
    }
  }
}

TEST(ErrorBound, IsNothingForAnExactLaw) {
  for (const double round_trip : {0.0, 0.100, 0.200}) {
    ClientSettings client = telling_client(round_trip, 1.0);
    client.uncertainty = 0.0;
    const Judged judged = press(client);
    EXPECT_EQ(judged.broken, 0);
    EXPECT_EQ(judged.unknown, 0);
    EXPECT_LT(*std::max_element(judged.bounds.begin(), judged.bounds.end()), 1e-6);
  }
}

/// A finger that wanders in and out of two soft stops, one of each joint, by the rule per contact,
/// against that rule on the simulation's own proxy and contacts.
Judged wander(const FingerDimensions& dimensions, const VecX& stop, double round_trip, double told,
              double uncertainty, int& contradicted) {
  constexpr double kDegree = M_PI / 180.0;
  constexpr int kBegin = 1000, kTicks = kBegin + 8000;
  PipelineConfig c;
  c.kinematics = make_finger_exoskeleton(dimensions);
  c.device.q_lower = (VecQ(2) << -0.01, -1.6).finished();
  c.device.q_upper = (VecQ(2) << 0.06, 1.6).finished();
  c.device.max_effort = c.scene.force_limit = c.scene.engage_window = VecA::Constant(1, 100.0);
  c.scene.renderer = RendererKind::kPerContact;
  c.scene.stiffness = VecA::Constant(1, kSpring);
  c.scene.damping = VecA::Zero(1);
  c.scene.slew_limit = VecA::Constant(1, 1e7);
  c.scene.staleness.hold_end = std::chrono::milliseconds(400);
  c.scene.staleness.fade_end = std::chrono::milliseconds(500);
  ClientSettings client = telling_client(round_trip, told);
  client.stop = kDegree * stop;
  client.uncertainty = uncertainty;
  PipelineLoop loop(c, client, 0.0);
  Renderer rule(RendererKind::kPerContact, *c.kinematics);
  Contacts contacts{.into = MatXQ::Identity(2, 2), .depth = VecX::Zero(2)};
  Judged judged;
  for (int k = 1; k <= kTicks; ++k) {
    const double t = 1e-3 * k;
    const VecX aim =
        client.stop +
        6.0 * kDegree * VecX(Eigen::Vector2d(std::sin(4.3 * t), std::sin(6.1 * t + 1.0)));
    VecQ q;
    EXPECT_EQ(c.kinematics->inverse(aim, q), InverseStatus::kExact);
    if (k == kBegin - 400) loop.engage();
    const TickRecord& record = loop.tick(q);
    if (k < kBegin) continue;
    const VecX& p = loop.x_probe();
    contacts.depth = p - client.stop;
    const VecX dx = -contacts.depth.cwiseMax(0.0) / (1.0 + kTrueGamma);
    Projection out;
    rule.project({q, p, loop.J(), {&contacts}}, p + dx, dx, c.scene.stiffness, true, out);
    const double shadow = kSpring * (out.q_star[0] - q[0]);
    judged.peak = std::max(judged.peak, std::abs(shadow));
    if (record.effort.error_bound.size() == 0) {
      ++judged.unknown;
      continue;
    }
    const double error = std::abs(record.effort.tau_elastic[0] - record.life.gain * shadow);
    judged.broken += error > record.effort.error_bound[0] + kRounding ? 1 : 0;
    contradicted += out.contradicted ? 1 : 0;
    if (shadow == 0.0) continue;
    judged.errors.push_back(error);
    judged.bounds.push_back(record.effort.error_bound[0]);
  }
  loop.require_engaged();
  return judged;
}

TEST(ErrorBound, HoldsByTheRulePerContact) {
  struct Linkage {
    FingerDimensions dimensions;
    VecX stop;  // degrees
    bool contradicts;
  };
  for (const auto& [dimensions, stop, contradicts] :
       {Linkage{{}, Eigen::Vector2d(30.0, 30.0), false},
        Linkage{finger_sign_change(), Eigen::Vector2d(20.0, 60.0), true}}) {
    int contradicted = 0;
    for (const double round_trip : {0.0, 0.020, 0.100, 0.200}) {
      for (const double told : {0.8, 1.0, 1.2}) {
        SCOPED_TRACE(std::to_string(round_trip) + " s, told " + std::to_string(told));
        const Judged judged = wander(dimensions, stop, round_trip, told, 0.25, contradicted);
        EXPECT_EQ(judged.broken, 0);
        EXPECT_EQ(judged.unknown, 0);
        if (told != 1.0 && round_trip > 0.0) {
          EXPECT_LT(median(judged.bounds), 5.0 * median(judged.errors));
        }
      }
      const Judged exact = wander(dimensions, stop, round_trip, 1.0, 0.0, contradicted);
      EXPECT_EQ(exact.broken, 0);
      EXPECT_LT(*std::max_element(exact.bounds.begin(), exact.bounds.end()), 1e-6);
    }
    EXPECT_EQ(contradicted > 1000, contradicts);
  }
}

TEST(ErrorBound, CountsForceHeldBack) {
  ClientSettings client = telling_client(0.100, 0.5);
  client.uncertainty = 0.5;
  const Judged judged = press(client, 0.0);
  EXPECT_EQ(judged.broken, 0);
  EXPECT_EQ(judged.unknown, 0);
}

TEST(ErrorBound, BreaksIfTheUncertaintyIsFalse) {
  ClientSettings client = telling_client(0.100, 2.0);
  client.uncertainty = 0.1;
  EXPECT_GT(press(client).broken, 0) << "the check can fail";
}

TEST(ErrorBound, IsUnknownIfNothingIsTold) {
  ClientSettings client = telling_client(0.020, 1.0);
  EXPECT_TRUE(press(client).bounds.empty()) << "no uncertainty";
  client.uncertainty = 0.0;
  client.anchored = false;
  EXPECT_TRUE(press(client).bounds.empty()) << "no anchor";
  client.compliance = 0.0;
  client.mode = ProxyMode::kHeld;
  EXPECT_TRUE(press(client).bounds.empty()) << "held";
}

}  // namespace
}  // namespace haptic::core::error_bound_test
