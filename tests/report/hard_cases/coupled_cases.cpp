/// core/METHOD.md#actuator-limits where it is hardest: a coupled Z_q that is all but singular, in
/// the whole tick.
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>

#include "haptic/core/model/linear.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "tests/report/hard_cases/hard_case.hpp"

namespace haptic::report {
namespace {

using core::VecA;
using core::VecQ;
using core::VecX;

/// Z_q = [a^2, r a b; r a b, b^2], r = 1 - 2^-40: exact in double, condition 2.3e12. Its weak
/// direction (b, -a) has 7e-10 N/m.
constexpr double kA = 30.0, kB = 25.0, kGap = 0x1p-40;
constexpr double kLimit[] = {5.0, 3.0};  // N

/// The law written out in the small difference 1 - r, by which nothing cancels; long double.
struct Law {
  long double tau[2], length;
  Law(double d1, double d2) {
    const long double along = static_cast<long double>(kA) * d1 + static_cast<long double>(kB) * d2;
    const long double weak = static_cast<long double>(kGap) * kA * kB;
    tau[0] = kA * along - weak * d2;
    tau[1] = kB * along - weak * d1;
    length = std::sqrt(std::max(0.0L, along * along - 2 * weak * d1 * d2));
    const long double scale = length > radius() ? radius() / length : 1.0L;
    tau[0] *= scale;
    tau[1] *= scale;
  }
  static long double radius() {
    return std::min(static_cast<long double>(kLimit[0]) / kA,
                    static_cast<long double>(kLimit[1]) / kB);
  }
  /// sqrt(tau^T Z_q^{-1} tau), for the sphere that saturation keeps the force in.
  static long double length_of(const VecA& tau) {
    const long double u = tau[0] / static_cast<long double>(kA);
    const long double v = tau[1] / static_cast<long double>(kB);
    const long double gap = kGap;
    return std::sqrt(((u - v) * (u - v) + 2 * gap * u * v) / (2 * gap - gap * gap));
  }
};

struct Bench {
  core::MatXQ A = (core::MatXQ(3, 3) << 1, 0.4, -0.3, 0.2, 1.1, 0.5, -0.6, 0.3, 0.9).finished();
  core::Pipeline pipeline;
  core::TickInput input{};

  explicit Bench(core::RendererKind kind) : pipeline(config(kind)) {
    input.settings = pipeline.config().scene;
    input.device.armed = input.device.fresh = true;
    input.command.lease_epoch = 1;
    input.command.lease_held = true;
    input.proxy.mode = core::ProxyMode::kHeld;
    input.proxy.epoch = 1;
  }
  core::TickRecord tick(const VecQ& q, const VecQ& target) {
    input.now += std::chrono::milliseconds(1);
    ++input.device.sample.seq;
    input.device.sample.time = input.now;
    input.device.sample.q = q;
    core::ProxySnapshot& proxy = input.proxy;
    proxy.x = A * target;
    proxy.born = input.now;
    if (++proxy.seq == 1) proxy.gapless_since = input.now;
    ++proxy.gapless_samples;
    return pipeline.tick(input);
  }

  /// Two actuated DoFs and a sensed one between them, three coordinates; without slew limit.
  [[nodiscard]] core::PipelineConfig config(core::RendererKind kind) const {
    core::LinearMap map;
    map.dofs = {{"a", core::Unit::kMetre, true, -1, 1},
                {"s", core::Unit::kMetre, false, -1, 1},
                {"b", core::Unit::kMetre, true, -1, 1}};
    for (const char* x : {"x", "y", "z"}) map.coordinates.push_back({x, core::Unit::kMetre});
    map.A = A;
    map.x_0 = VecX::Zero(3);
    core::PipelineConfig c;
    c.kinematics = core::make_linear(map);
    const double coupled = (1.0 - kGap) * kA * kB;
    c.projection.coupling = std::make_shared<const core::StiffnessCoupling>(
        (Eigen::Matrix2d() << kA * kA, coupled, coupled, kB * kB).finished());
    c.device.q_lower = VecQ::Constant(3, -2.0);
    c.device.q_upper = VecQ::Constant(3, 2.0);
    c.device.max_effort = VecA::Constant(2, 40.0);
    c.scene.renderer = kind;
    c.scene.stiffness = c.projection.coupling->scene_stiffness();
    c.scene.damping = VecA::Zero(2);
    c.scene.force_limit = (VecA(2) << kLimit[0], kLimit[1]).finished();
    c.scene.slew_limit = VecA::Constant(2, 1e9);
    c.scene.engage_window = VecA::Constant(2, 1e3);
    return c;
  }
};

/// Deviations of millimetres in every direction, and of decimetres along the weak one.
void nearly_singular(Outcomes& out) {
  double error = 0.0, sphere = 0.0;
  bool within = true, engaged = true;
  int saturated = 0, ticks = 0;
  for (const core::RendererKind kind :
       {core::RendererKind::kSubspaceLinear, core::RendererKind::kSubspaceExact}) {
    Bench bench(kind);
    std::mt19937_64 random(45);
    std::uniform_real_distribution<double> part(-1.0, 1.0);
    const VecQ rest = VecQ::Zero(3);
    for (int i = 0; i < 250; ++i) static_cast<void>(bench.tick(rest, rest));
    ++bench.input.command.engage_id;
    for (int i = 0; i < 250; ++i) static_cast<void>(bench.tick(rest, rest));
    for (int i = 0; i < 2000; ++i) {
      const double weak = i % 2 == 0 ? 0.01 * part(random) : 0.0;
      const VecQ q =
          (VecQ(3) << 0.006 * part(random), 0.1 * part(random), 0.006 * part(random)).finished();
      const VecQ target = (VecQ(3) << 0.006 * part(random) + kB * weak, 0.1 * part(random),
                           0.006 * part(random) - kA * weak)
                              .finished();
      const core::TickRecord record = bench.tick(q, target);
      const Law law(target[0] - q[0], target[2] - q[2]);
      for (int k = 0; k < 2; ++k) {
        const auto off = static_cast<double>(std::abs(record.effort.tau_a[k] - law.tau[k]));
        error = std::max(error, off);  // a NaN is within no limit
        within = within && std::abs(record.effort.tau_a[k]) <= kLimit[k];
      }
      sphere = std::max(sphere,
                        static_cast<double>(Law::length_of(record.effort.tau_a) / Law::radius()));
      saturated += law.length > Law::radius() ? 1 : 0;
      engaged = engaged && record.life.state == core::DeviceState::kEngaged;
      ++ticks;
    }
  }
  out.push_back({"13b",
                 "core/METHOD.md#actuator-limits, Z_q of condition 2.3e12, Eq. (6) and (8): tau = "
                 "Z_q d min(1, rho/L) "
                 "to 1e-11 N, "
                 "finite, each actuator within its limit, the whole within the sphere of rho",
                 said("%d ticks, %d saturated: error %.1e N, limits %s, length at most rho (%+.0e)",
                      ticks, saturated, error, within ? "kept" : "passed", sphere - 1.0),
                 engaged && within && error < 1e-11 && sphere < 1.0 + 1e-7 && saturated > 500 &&
                     saturated < ticks - 500});
}

}  // namespace

void coupled_cases(Outcomes& out) {
  nearly_singular(out);
}

}  // namespace haptic::report
