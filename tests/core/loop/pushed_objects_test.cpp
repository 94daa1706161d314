// Objects that are pushed by a press behind a network (core/METHOD.md#pushed-objects). The object
// is integrated here, finely and by another rule than the server's.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tests/core/loop/rail_press.hpp"

namespace haptic::core::press {
namespace {

constexpr double kBothSprings = 1.0 / (1.0 / Rails::coupling + 1.0 / kObject);  // N/m, both springs

struct Pushed {
  double mass{0.2}, damping{1.0}, ground{200.0};  // kg, N s/m, N/m
  double told{1.0};                               ///< of the mass
  double round_trip{0.050};                       ///< s
  double rate{60.0};                              ///< samples/s
  double disturbance{0.0};                        ///< N, at 1.3 Hz
  double hidden{0.0};                             ///< the same, not told
  bool named{true};                               ///< the contact, from sample to sample
  bool tells_law{true};
  double amplitude{kLight};  ///< of the hand about the surface, m
  double tank{-1.0};
  double judged_from{0.0};  ///< s, of 8
};

/// The object: an independent integration, by steps of 20 us of velocity Verlet.
class Object {
 public:
  explicit Object(const Pushed& p) : p_(p), probe_(-p.amplitude) {}
  /// Over a tick that ends at `t` s after the hand began with the probe at `probe`.
  void step(double t, double probe) {
    constexpr int kSteps = 50;
    constexpr double dt = 1e-3 / kSteps;
    const double before = std::exchange(probe_, probe);
    for (int i = 1; i <= kSteps; ++i) {
      const double at = before + (probe - before) * i / kSteps;
      const double phase = 2.0 * M_PI * 1.3 * std::max(0.0, t - (kSteps - i) * dt);
      disturbance = (p_.disturbance + p_.hidden) * std::sin(phase);
      const auto push = [&] {
        return kBothSprings * std::max(0.0, at - s) + disturbance - p_.ground * s;
      };
      const double half = v + 0.5 * dt * (push() - p_.damping * v) / p_.mass;
      s += dt * half;
      v = (half + 0.5 * dt * push() / p_.mass) / (1.0 + 0.5 * dt * p_.damping / p_.mass);
    }
  }
  /// A sample of it.
  void tell(haptic::test::Frame& frame) const {
    const double probe = frame.x_probe[0];
    frame.computed_s = frame.seen_s;
    frame.anchored = true;
    frame.x = one(probe - kBothSprings * std::max(0.0, probe - s) / Rails::coupling);
    frame.walls.normals = MatXQ::Identity(1, 1);
    frame.walls.offsets = one(s);
    frame.walls.compliance = one(kGamma);
    frame.walls.velocity = one(v);
    if (!p_.tells_law) return;
    const double told = p_.hidden > 0.0 ? 0.0 : disturbance;
    frame.walls.laws.resize(4, 1);
    frame.walls.laws << p_.told * p_.mass, p_.damping, p_.ground, told - p_.ground * s;
    frame.walls.laws /= Rails::coupling;
    frame.walls.ids = one(p_.named ? 1.0 : 0.0);
  }

  double s{0.0}, v{0.0}, disturbance{0.0};  // m, m/s, N

 private:
  Pushed p_;
  double probe_;
};

/// For SCOPED_TRACE.
std::ostream& operator<<(std::ostream& out, const Pushed& p) {
  return out << p.mass << " kg told " << p.told << ", " << p.ground << " N/m, " << p.rate << "/s, "
             << p.round_trip << " s";
}

Figures feel(const Pushed& p) {
  Object object(p);
  Press press{.pipeline = patient_rail(p.tank),
              .client = {.mode = ProxyMode::kPlanes,
                         .simulate = [&](haptic::test::Frame& frame) { object.tell(frame); },
                         .rate_hz = p.rate,
                         .delay_s = p.round_trip},
              .amplitude = p.amplitude,
              .judged_from = p.judged_from,
              .felt_is_contact = true};
  press.shadow = [&](const TickRecord& record) {
    return -kBothSprings * std::max(0.0, record.sensed.q[0] - object.s);
  };
  press.world = [&](double t, double q) { object.step(t, q); };
  return felt(press);
}

/// Springy ones with a damping of 0.3 of the critical, and one that slides.
std::vector<Pushed> objects() {
  std::vector<Pushed> all{{.mass = 0.02}, {.mass = 0.2}, {.mass = 2.0, .ground = 500.0}};
  for (Pushed& p : all) p.damping = 0.6 * std::sqrt(p.ground * p.mass);
  all.push_back({.mass = 2.0, .damping = 20.0, .ground = 0.0});
  return all;
}

TEST(PushedObjects, DelayIsNotFelt) {
  for (Pushed p : objects()) {
    for (const double rate : {30.0, 60.0, 200.0, 1000.0}) {
      for (const double round_trip : {0.0, 0.020, 0.050, 0.100, 0.200}) {
        p.rate = rate;
        p.round_trip = round_trip;
        SCOPED_TRACE(p);
        const Figures f = feel(p);
        EXPECT_GT(f.peak, 1.5);
        // An object that slides away is judged by its first touch, when little is known of its
        // mass.
        EXPECT_LT(f.error, (p.ground == 0.0 ? 2.5e-3 : 1e-3) * f.peak);
      }
    }
  }
}

TEST(PushedObjects, WrongMassNeverDiverges) {
  for (Pushed p : objects()) {
    for (const double told : {0.5, 2.0}) {
      for (const double rate : {30.0, 1000.0}) {
        for (const double round_trip : {0.0, 0.050, 0.100, 0.200}) {
          p.told = told;
          p.rate = rate;
          p.round_trip = round_trip;
          SCOPED_TRACE(p);
          const Figures f = feel(p);
          EXPECT_LT(f.largest, f.peak);
          // An object that slides is pushed once, and 100 ms of that are over before a sample tells
          // of it.
          const bool blind = p.ground == 0.0 && round_trip > 0.050;
          EXPECT_LT(f.error, (!blind ? 0.025 : round_trip > 0.1 ? 0.18 : 0.06) * f.peak);
        }
      }
    }
  }
}

TEST(PushedObjects, SamplesTellTheMass) {
  for (Pushed p : objects()) {
    if (p.ground == 0.0) continue;
    for (const double told : {0.5, 2.0}) {
      p.told = told;
      p.round_trip = 0.200;
      p.judged_from = 1.5;  // the second push
      p.named = true;
      SCOPED_TRACE(p);
      const Figures learnt = feel(p);
      EXPECT_LT(learnt.error, 0.01 * learnt.peak);
      p.named = false;
      const Figures told_wrong = feel(p);
      EXPECT_GT(told_wrong.error, (p.mass < 0.1 ? 1.1 : 5.0) * learnt.error);
    }
  }
}

TEST(PushedObjects, UntoldForceIsNotMass) {
  for (Pushed p : objects()) {
    p.hidden = 0.1;
    p.round_trip = 0.100;
    SCOPED_TRACE(p);
    const Figures learnt = feel(p);
    p.named = false;
    EXPECT_LT(learnt.error, 1.25 * feel(p).error);
  }
}

TEST(PushedObjects, LoadTellsADisturbance) {
  for (Pushed p : objects()) {
    p.disturbance = 0.5;
    p.round_trip = 0.020;
    SCOPED_TRACE(p);
    // At most what the disturbance changes in a round trip and a period: 0.15 N.
    EXPECT_LT(feel(p).largest, 2.0 * M_PI * 1.3 * 0.5 * (0.020 + 1.3 / p.rate));
  }
}

TEST(PushedObjects, RightLawIsNeverHeldBack) {
  for (Pushed p : objects()) {
    for (const double round_trip : {0.0, 0.100}) {
      p.round_trip = round_trip;
      p.amplitude = 0.07;  // 0.1 to 0.3 J in the objects, 0.05 fit into the tank
      p.tank = 0.0;
      SCOPED_TRACE(p);
      const Figures f = feel(p);
      EXPECT_EQ(f.held_back, 0.0);
      EXPECT_LT(f.error, 1e-3 * f.peak);
      EXPECT_LE(f.given, 1e-9);
    }
  }
}

TEST(PushedObjects, TankBoundsAWrongLaw) {
  for (const double told : {0.01, 0.1, 10.0}) {
    Pushed p{.told = told, .round_trip = 0.100, .tank = 2e-3};
    EXPECT_LE(feel(p).given, 2e-3 + 1e-9) << told;
  }
}

TEST(PushedObjects, VelocityAloneGivesEnergy) {
  Pushed p{.round_trip = 0.100};
  p.damping = 0.6 * std::sqrt(p.ground * p.mass);
  EXPECT_LE(feel(p).given, 1e-9);
  p.tells_law = false;
  EXPECT_GT(feel(p).given, 1.0);
}

}  // namespace
}  // namespace haptic::core::press
