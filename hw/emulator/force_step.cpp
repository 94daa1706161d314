#include "hw/emulator/force_step.hpp"

#include <algorithm>
#include <cmath>

#include "hw/random.hpp"

namespace haptic::hw::emulator {
namespace {

constexpr int kPeriodUs = 1000;  // the board's
constexpr double kPeriod = kPeriodUs / 1e6;
constexpr int kSteps = kPeriodUs / Rig::kStepUs;
constexpr int kSettle = 2000, kLast = 1000;

}  // namespace

ForceStep measure_force_step(const EmulatorConfig& config, double from, double to, double l) {
  // The board's loop on an actuator that presses against a wall.
  LinearActuator actuator(config.actuator, l);
  core::ForceLoop loop(config.force_loop);
  Gaussian noise(config.seed);
  const auto tick = [&](double reference) {
    const double measured = actuator.force() + config.sensors.noise_force * noise();
    actuator.drive(loop.step(reference, measured, kPeriod), true);
    for (int i = 0; i < kSteps; ++i) actuator.step(Rig::kStep, l, 0.0);
    return actuator.force();  // the true one, N
  };
  for (int i = 0; i < kSettle; ++i) static_cast<void>(tick(from));
  ForceStep result;
  result.settled = true;
  double at_10 = -1.0, at_90 = -1.0, peak = 0.0;
  for (int i = 0; i < kSettle; ++i) {
    const double share = (tick(to) - from) / (to - from);
    const double t = kPeriod * (i + 1);
    if (at_10 < 0.0 && share >= 0.1) at_10 = t;
    if (at_90 < 0.0 && share >= 0.9) at_90 = t;
    peak = std::max(peak, share);
    const double allowed = 0.05 + 3.0 * config.sensors.noise_force / std::abs(to - from);
    if (i >= kSettle - kLast && std::abs(share - 1.0) > allowed) result.settled = false;
  }
  if (at_90 < 0.0) return {0.0, 0.0, 0.0, false};
  result.rise = std::max(at_90 - at_10, kPeriod);
  result.bandwidth = 0.35 / result.rise;
  result.overshoot = std::max(0.0, peak - 1.0);
  return result;
}

}  // namespace haptic::hw::emulator
