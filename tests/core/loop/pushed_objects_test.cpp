// Objects that are pushed, on the real pipeline in virtual time (core/METHOD.md#pushed-objects): a
// hand pushes an object whose simulation is behind a network. The object is integrated here, finely
// and by another rule than the server's.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/loop/pipeline_loop.hpp"
#include "tests/support/loop/rails.hpp"

namespace haptic::core {
namespace {

/// Device and hand: kg, N s/m, N/m. (A unity build has the names of contacts_test.cpp too.)
struct World {
  static constexpr double coupling = 1500.0, contact = 500.0;
  static constexpr double felt = 1.0 / (1.0 / coupling + 1.0 / contact);
  static constexpr double device = 0.3, device_damping = 2.0;
  static constexpr double hand = 800.0, hand_damping = 8.0;
  static constexpr double tick = 1e-3;
};

struct Pushed {
  double mass{0.2}, damping{1.0}, ground{200.0};  // kg, N s/m, N/m
  double told{1.0};                               ///< of the mass
  double round_trip{0.050};                       ///< s
  double rate{60.0};                              ///< samples/s
  double disturbance{0.0};                        ///< N, at 1.3 Hz
  double hidden{0.0};                             ///< the same, not told
  bool named{true};                               ///< the contact, from sample to sample
  bool tells_law{true};
  double amplitude{0.018};  ///< of the hand about the surface, m
  double tank{-1.0};
  double judged_from{0.0};  ///< s, of 8
};

struct PushedFigures {
  double rms{0.0}, worst{0.0}, peak{0.0}, held_back{0.0}, net{0.0};
};

/// The object: an independent integration, by steps of 20 us of velocity Verlet.
struct Object {
  double s{0.0}, v{0.0}, push{0.0};
  void step(const Pushed& p, double probe, double disturbance, double dt) {
    const auto force = [&](double at) { return World::felt * std::max(0.0, probe - at); };
    const auto acceleration = [&](double at, double speed) {
      return (force(at) + disturbance - p.damping * speed - p.ground * at) / p.mass;
    };
    const double half = v + 0.5 * dt * acceleration(s, v);
    s += dt * half;
    v = (half + 0.5 * dt * (force(s) + disturbance - p.ground * s) / p.mass) /
        (1.0 + 0.5 * dt * p.damping / p.mass);
    push = force(s);
  }
};

struct OnTheWay {
  double arrives{0.0};
  ProxySnapshot proxy{};
};

OnTheWay told_by(const Pushed& p, const Object& object, double probe, double disturbance,
                 int tick) {
  OnTheWay sample;
  ProxySnapshot& proxy = sample.proxy;
  proxy.mode = ProxyMode::kPlanes;
  proxy.tenure = 1;
  proxy.x =
      VecX::Constant(1, probe - World::felt * std::max(0.0, probe - object.s) / World::coupling);
  proxy.anchored_at = static_cast<std::uint64_t>(tick);
  proxy.planes.normals = MatXQ::Identity(1, 1);
  proxy.planes.offsets = VecX::Constant(1, object.s);
  proxy.planes.compliance = VecX::Constant(1, World::coupling / World::contact);
  proxy.planes.velocity = VecX::Constant(1, object.v);
  proxy.computed = TimePoint(std::chrono::milliseconds(tick));
  if (!p.tells_law) return sample;
  proxy.planes.laws.resize(4, 1);
  proxy.planes.laws << p.told * p.mass, p.damping, p.ground, disturbance - p.ground * object.s;
  proxy.planes.laws /= World::coupling;
  proxy.planes.ids = VecX::Constant(1, p.named ? 1.0 : 0.0);
  return sample;
}

PushedFigures feel(const Pushed& p) {
  constexpr int kSubsteps = 50, kBegin = 1000, kTicks = kBegin + 8000;
  Pipeline pipeline(haptic::test::patient_rail(p.tank));
  haptic::test::EnergyBook book(World::device_damping);
  haptic::test::Random random(7);
  TickInput in;
  in.settings = pipeline.config().scene;
  in.device.fresh = in.device.armed = true;
  in.command.tenure = 1;
  in.command.lease_held = true;
  std::vector<OnTheWay> on_the_way;
  Object object;
  PushedFigures f;
  double q = -p.amplitude, u = 0.0, tau = 0.0, next_look = 0.0, squares = 0.0;
  std::uint64_t made = 0;
  int contact = 0, held_back = 0;
  for (int k = 1; k <= kTicks; ++k) {
    const double before = q;
    double disturbance = 0.0;
    for (int i = 0; i < kSubsteps; ++i) {
      constexpr double dt = World::tick / kSubsteps;
      const double t = std::max(0.0, (k - kBegin) * World::tick + i * dt), w = 2.0 * M_PI * 0.7;
      const double aim = -p.amplitude * std::cos(w * t);
      const double aim_dot = p.amplitude * w * std::sin(w * t);
      const double push = World::hand * (aim - q) + World::hand_damping * (aim_dot - u) + tau;
      u = (u + dt * push / World::device) / (1.0 + dt * World::device_damping / World::device);
      q += dt * u;
      disturbance = (p.disturbance + p.hidden) * std::sin(2.0 * M_PI * 1.3 * t);
      object.step(p, q, disturbance, dt);
    }
    if (k > 1) book.add(VecA::Constant(1, tau), VecA::Constant(1, q - before), World::tick);
    const double now = k * World::tick;
    if (now + 1e-9 >= next_look) {
      next_look += (1.0 + 0.3 * (2.0 * random.uniform() - 1.0)) / p.rate;
      OnTheWay sample = told_by(p, object, q, p.hidden > 0.0 ? 0.0 : disturbance, k);
      sample.proxy.seq = ++made;
      sample.arrives = now + p.round_trip;
      on_the_way.push_back(sample);
    }
    in.now = in.device.sample.time = TimePoint(std::chrono::milliseconds(k));
    in.device.sample.seq = static_cast<std::uint64_t>(k);
    in.device.sample.q = VecQ::Constant(1, q);
    for (const OnTheWay& sample : on_the_way) {
      if (sample.arrives > now + 1e-9 || sample.proxy.seq <= in.proxy.seq) continue;
      const auto samples = in.proxy.gapless_samples;
      in.proxy = sample.proxy;
      in.proxy.born = in.now;
      in.proxy.gapless_samples = samples + 1;
    }
    std::erase_if(on_the_way, [&](const OnTheWay& s) { return s.arrives <= now + 1e-9; });
    if (k == kBegin - 400) in.command.engage_id = 1;
    const TickRecord record = pipeline.tick(in);
    tau = record.effort.tau_a[0];
    if (now < kBegin * World::tick + p.judged_from) continue;
    const double shadow = -World::felt * std::max(0.0, q - object.s);
    f.peak = std::max(f.peak, -shadow);
    if (shadow == 0.0 && tau == 0.0) continue;
    ++contact;
    squares += (tau - shadow) * (tau - shadow);
    f.worst = std::max(f.worst, std::abs(tau - shadow));
    held_back += record.limiters().has(Limiter::kEnergyTank) ? 1 : 0;
  }
  f.rms = std::sqrt(squares / std::max(contact, 1));
  f.held_back = static_cast<double>(held_back) / std::max(contact, 1);
  f.net = book.most_net();
  return f;
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
        SCOPED_TRACE(std::to_string(p.mass) + " kg, " + std::to_string(p.ground) + " N/m, " +
                     std::to_string(rate) + "/s, " + std::to_string(round_trip) + " s");
        const PushedFigures f = feel(p);
        EXPECT_GT(f.peak, 1.5);
        // An object that slides away is judged by its first touch, when little is known of its
        // mass.
        EXPECT_LT(f.rms, (p.ground == 0.0 ? 2.5e-3 : 1e-3) * f.peak);
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
          SCOPED_TRACE(std::to_string(p.mass) + " kg told " + std::to_string(told) + ", " +
                       std::to_string(p.ground) + " N/m, " + std::to_string(rate) + "/s, " +
                       std::to_string(round_trip) + " s");
          const PushedFigures f = feel(p);
          EXPECT_LT(f.worst, f.peak);
          // An object that slides is pushed once, and 100 ms of that are over before a sample tells
          // of it.
          const bool blind = p.ground == 0.0 && round_trip > 0.050;
          EXPECT_LT(f.rms, (!blind ? 0.025 : round_trip > 0.1 ? 0.18 : 0.05) * f.peak);
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
      SCOPED_TRACE(std::to_string(p.mass) + " kg told " + std::to_string(told));
      p.named = true;
      const PushedFigures learnt = feel(p);
      EXPECT_LT(learnt.rms, 0.01 * learnt.peak);
      p.named = false;
      const PushedFigures told_wrong = feel(p);
      EXPECT_GT(told_wrong.rms, (p.mass < 0.1 ? 1.1 : 5.0) * learnt.rms);
    }
  }
}

TEST(PushedObjects, UntoldForceIsNotMass) {
  for (Pushed p : objects()) {
    p.hidden = 0.1;
    p.round_trip = 0.100;
    SCOPED_TRACE(std::to_string(p.mass) + " kg, " + std::to_string(p.ground) + " N/m");
    const PushedFigures learnt = feel(p);
    p.named = false;
    EXPECT_LT(learnt.rms, 1.25 * feel(p).rms);
  }
}

TEST(PushedObjects, LoadTellsADisturbance) {
  for (Pushed p : objects()) {
    p.disturbance = 0.5;
    p.round_trip = 0.020;
    SCOPED_TRACE(std::to_string(p.mass) + " kg, " + std::to_string(p.ground) + " N/m");
    // At most what the disturbance changes in a round trip and a period: 0.15 N.
    EXPECT_LT(feel(p).worst, 2.0 * M_PI * 1.3 * 0.5 * (0.020 + 1.3 / p.rate));
  }
}

TEST(PushedObjects, RightLawIsNeverHeldBack) {
  for (Pushed p : objects()) {
    for (const double round_trip : {0.0, 0.100}) {
      p.round_trip = round_trip;
      p.amplitude = 0.07;  // 0.1 to 0.3 J in the objects, 0.05 fit into the tank
      p.tank = 0.0;
      SCOPED_TRACE(std::to_string(p.mass) + " kg, " + std::to_string(round_trip) + " s");
      const PushedFigures f = feel(p);
      EXPECT_EQ(f.held_back, 0.0);
      EXPECT_LT(f.rms, 1e-3 * f.peak);
      EXPECT_LE(f.net, 1e-9);
    }
  }
}

TEST(PushedObjects, TankBoundsAWrongLaw) {
  for (const double told : {0.01, 0.1, 10.0}) {
    Pushed p{.told = told, .round_trip = 0.100, .tank = 2e-3};
    EXPECT_LE(feel(p).net, 2e-3 + 1e-9) << told;
  }
}

TEST(PushedObjects, VelocityAloneGivesEnergy) {
  Pushed p{.round_trip = 0.100};
  p.damping = 0.6 * std::sqrt(p.ground * p.mass);
  EXPECT_LE(feel(p).net, 1e-9);
  p.tells_law = false;
  EXPECT_GT(feel(p).net, 1.0);
}

}  // namespace
}  // namespace haptic::core
