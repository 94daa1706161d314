// The bound of the felt force's error (core/METHOD.md#error-bound), in a press behind a network.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/core/loop/rail_press.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/support/angles.hpp"

namespace haptic::core::press {
namespace {

ClientSettings telling_client(double round_trip_s, double told) {
  ClientSettings client = wall_client(round_trip_s);
  client.told_compliance = told * kGamma;
  client.lost = 0.1;
  return client;
}

/// Kept, and known as long as it is a small share of the force.
void expect_bound(const report::ShadowFigures& f, double known) {
  EXPECT_EQ(f.kept, 1.0);
  EXPECT_GE(f.bounded, known);
}
/// Nor vacuous.
void expect_narrow(const report::ShadowFigures& f) {
  EXPECT_LT(f.bound_median, 5.0 * f.error_median);
}

TEST(ErrorBound, HoldsAtAnyDelay) {
  for (const double round_trip : {0.0, 0.020, 0.050, 0.100, 0.200}) {
    for (const double told : {0.8, 1.0, 1.2}) {
      SCOPED_TRACE(std::to_string(round_trip) + " s, told " + std::to_string(told));
      ClientSettings client = telling_client(round_trip, told);
      client.uncertainty = 0.2;
      const Figures f = felt({.client = client});
      expect_bound(f, 0.85);
      if (told != 1.0 && round_trip > 0.0) expect_narrow(f);
    }
  }
}

TEST(ErrorBound, IsNothingForAnExactLaw) {
  for (const double round_trip : {0.0, 0.100, 0.200}) {
    Press press{.client = telling_client(round_trip, 1.0)};
    press.client.uncertainty = 0.0;
    double largest = 0.0;
    press.observe = [&](const TickRecord& record) {
      const VecA& bound = record.effort.error_bound;
      if (bound.size() > 0 && record.life.gain == 1.0) largest = std::max(largest, bound[0]);
    };
    expect_bound(felt(press), 1.0);
    EXPECT_LT(largest, 1e-6);
  }
}

/// A finger that wanders in and out of two soft stops (degrees), one of each joint, by the rule per
/// contact, against that rule on the simulation's own proxy and contacts.
report::ShadowFigures wander(const FingerDimensions& dimensions, const VecX& stop,
                             double round_trip, double told, double uncertainty,
                             int& contradicted) {
  Press press{.client = telling_client(round_trip, told)};
  PipelineConfig& c = press.pipeline;
  c.kinematics = make_finger_exoskeleton(dimensions);
  c.device.q_lower = two(-0.01, -1.6);
  c.device.q_upper = two(0.06, 1.6);
  c.scene.renderer = RendererKind::kPerContact;
  press.client.stop = kDegree * stop;
  press.client.uncertainty = uncertainty;
  press.device = [&](double t) {
    const VecX aim =
        press.client.stop + 6.0 * kDegree * two(std::sin(4.3 * t), std::sin(6.1 * t + 1.0));
    VecQ q;
    EXPECT_EQ(c.kinematics->inverse(aim, q), InverseStatus::kExact);
    return q;
  };
  Renderer rule(RendererKind::kPerContact, *c.kinematics);
  Contacts contacts{.into = MatXQ::Identity(2, 2), .depth = VecX::Zero(2)};
  press.shadow = [&](const TickRecord& record) {
    const VecX& p = record.anchor.x_probe;
    contacts.depth = p - press.client.stop;
    const VecX x = p - contacts.depth.cwiseMax(0.0) / (1.0 + kGamma);
    const Instant at(*c.kinematics, record.sensed.q, x);
    const Projection out = projected(rule, at, c.scene.stiffness, true, {&contacts});
    contradicted += out.contradicted ? 1 : 0;
    return spring_force(c.kinematics->layout(), out, at.q, c.scene.stiffness)[0];
  };
  return felt(press);
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
        const auto f = wander(dimensions, stop, round_trip, told, 0.25, contradicted);
        expect_bound(f, 0.6);
        if (told != 1.0 && round_trip > 0.0) expect_narrow(f);
      }
      const auto exact = wander(dimensions, stop, round_trip, 1.0, 0.0, contradicted);
      EXPECT_EQ(exact.kept, 1.0);
      EXPECT_LT(exact.bound_median, 1e-6);
    }
    EXPECT_EQ(contradicted > 1000, contradicts);
  }
}

TEST(ErrorBound, IsAShareOfTheForce) {
  Press press{.client = telling_client(0.100, 0.5)};
  press.client.uncertainty = 0.5;
  int known = 0, ticks = 0;
  press.observe = [&](const TickRecord& record) {
    const double force = std::abs(record.effort.tau_elastic[0]);
    if (record.life.gain < 1.0 || force == 0.0) return;
    ++ticks;
    if (record.effort.error_bound.size() == 0) return;
    ++known;
    const double least = 0.002 * press.pipeline.scene.force_limit[0];
    EXPECT_LE(record.effort.error_bound[0], std::max(0.25 * force, least) + 1e-9);
  };
  EXPECT_EQ(felt(press).kept, 1.0);
  EXPECT_GT(known, ticks / 4);
  EXPECT_LT(known, ticks);
}

TEST(ErrorBound, CountsForceHeldBack) {
  ClientSettings client = telling_client(0.100, 0.5);
  client.uncertainty = 0.5;
  expect_bound(felt({.pipeline = patient_rail(0.0), .client = client}), 0.5);
}

TEST(ErrorBound, BreaksIfTheUncertaintyIsFalse) {
  ClientSettings client = telling_client(0.100, 2.0);
  client.uncertainty = 0.1;
  EXPECT_LT(felt({.client = client}).kept, 1.0) << "the check can fail";
}

TEST(ErrorBound, IsUnknownIfNothingIsTold) {
  ClientSettings client = telling_client(0.020, 1.0);
  EXPECT_EQ(felt({.client = client}).bounded, 0.0) << "no uncertainty";
  client.uncertainty = 0.0;
  client.anchored = false;
  EXPECT_EQ(felt({.client = client}).bounded, 0.0) << "no anchor";
  client.compliance = 0.0;
  client.mode = ProxyMode::kHeld;
  EXPECT_EQ(felt({.client = client}).bounded, 0.0) << "held";
}

}  // namespace
}  // namespace haptic::core::press
