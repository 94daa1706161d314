#pragma once
/// The press of core/METHOD.md#contacts on the real pipeline in virtual time: a hand swings a mass
/// in and out of an object whose simulation is behind a network. The force is judged by its shadow:
/// that of the same object without delay, on the probe that was really felt.

#include <algorithm>
#include <functional>

#include "tests/report/analysis/shadow_judge.hpp"
#include "tests/support/loop/pipeline_loop.hpp"
#include "tests/support/loop/rails.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core::press {

using haptic::test::ClientSettings;
using haptic::test::patient_rail;
using haptic::test::Rails;

constexpr double kObject = 500.0;                     // N/m
constexpr double kGamma = Rails::coupling / kObject;  ///< its compliance
constexpr double kLight = 0.018, kHard = 0.0353;      // m of the hand: 4.6 and 9 N

/// A simulation of a soft wall at 0 that tells it as a contact, always. `compliance` 0: rigid.
inline ClientSettings wall_client(double round_trip_s, ProxyMode mode = ProxyMode::kPlanes,
                                  double compliance = kGamma) {
  ClientSettings client;
  client.mode = mode;
  client.stop = VecX::Zero(1);
  client.compliance = compliance;
  client.delay_s = round_trip_s;
  return client;
}

struct Press {
  PipelineConfig pipeline = patient_rail();
  ClientSettings client{};
  double amplitude{kLight}, frequency{0.7};  ///< of the hand about 0, m, Hz
  double judged_from{0.0};                   ///< s after the hand began, of 8
  bool felt_is_contact{false};               ///< a force counts as contact, if it should not be
  /// Place of the device at a time; none: the hand swings a rail.
  std::function<VecQ(double t)> device{};
  /// Force of the object itself, N.
  std::function<double(const TickRecord&)> shadow = [](const TickRecord& record) {
    return -Rails::coupling * std::max(0.0, record.sensed.q[0]) / (1.0 + kGamma);
  };
  std::function<void(double t, double q)> world{};   ///< moves on at each tick
  std::function<void(const TickRecord&)> observe{};  ///< every tick
};

struct Figures : report::ShadowFigures {
  double given{0.0};  ///< J, most beyond the device's own damping
};

inline Figures felt(const Press& what) {
  constexpr int kBegin = 1000;
  haptic::test::PipelineLoop loop(what.pipeline, what.client, Rails::damping);
  haptic::test::HandMasses mass(haptic::test::swinging(what.frequency, what.amplitude));
  report::ShadowJudge judge;
  for (int k = 1; k <= kBegin + 8000; ++k) {
    const double t = (k - kBegin) * 1e-3;
    mass.step(t, loop.tau_a());
    const VecQ q = what.device ? what.device(t) : mass.q();
    if (what.world) what.world(t, q[0]);
    if (k == kBegin - 400) loop.engage();
    const TickRecord& record = loop.tick(q);
    if (what.observe) what.observe(record);
    if (t < what.judged_from) continue;
    const double shadow = record.life.gain * what.shadow(record);
    judge.add({.felt = record.effort.tau_elastic,
               .shadow = one(shadow),
               .elastic = record.effort.tau_elastic,
               .touching = shadow != 0.0 || (what.felt_is_contact && loop.tau() != 0.0),
               .held_back = record.limiters().has(Limiter::kEnergyTank),
               .clearance = 1.0,  // all that is felt out of contact is drag
               .bound = record.effort.error_bound});
  }
  loop.require_engaged();
  return {judge.figures(), loop.energy().most_net()};
}

}  // namespace haptic::core::press
