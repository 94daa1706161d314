// core/METHOD.md#actuator-limits in the tick: a Z_q that is not diagonal, saturated as a whole;
// 5.2-5.4 with it.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/core/model/sample_maps.hpp"
#include "tests/core/tick/driven.hpp"
#include "tests/support/pressing_hand.hpp"

namespace haptic::core {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

const Matrix2d kZ = (Matrix2d() << 900.0, 500.0, 500.0, 600.0).finished();
const Vector2d kLimit(5.0, 3.0);  // N; 3/sqrt(600) is less than 5/sqrt(900)
constexpr RendererKind kSubspace[] = {RendererKind::kSubspaceLinear, RendererKind::kSubspaceExact};

/// core/METHOD.md#actuator-limits, written out.
Vector2d law(const Vector2d& d, const Matrix2d& Z = kZ, const Vector2d& limit = kLimit) {
  const double r = std::min(limit[0] / std::sqrt(Z(0, 0)), limit[1] / std::sqrt(Z(1, 1)));
  const double length = std::sqrt(d.dot(Z * d));
  return (length > r ? r / length : 1.0) * (Z * d);
}

const MatXQ& map_matrix() {
  static const MatXQ A = (MatXQ(3, 3) << 1, 0.4, -0.3, 0.2, 1.1, 0.5, -0.6, 0.3, 0.9).finished();
  return A;
}

/// Three DoFs, the first and the third actuated, three coordinates.
PipelineConfig coupled_config(RendererKind renderer, const Matrix2d& Z = kZ) {
  LinearMap map = samples::linear_parameters(map_matrix(), 3, 1.0);
  map.dofs[1].actuated = false;
  PipelineConfig c = pressing_config(make_linear(map), renderer);
  c.projection.coupling = std::make_shared<const StiffnessCoupling>(Z);
  c.scene.stiffness = c.projection.coupling->scene_stiffness();
  c.scene.damping = VecA::Zero(2);
  c.scene.force_limit = kLimit;
  c.scene.slew_limit = VecA::Constant(2, 1e9);
  return c;
}

class CoupledBench : public test::DrivenPipeline {
 public:
  explicit CoupledBench(const PipelineConfig& config) : DrivenPipeline(config) {
    input.device.sample.q = target = VecQ::Zero(3);
  }
  VecQ& q() { return input.device.sample.q; }
  [[nodiscard]] Vector2d q_a() const {
    return {input.device.sample.q[0], input.device.sample.q[2]};
  }
  [[nodiscard]] Vector2d d() const {  // S (q* - q) of the map's own inverse
    return {target[0] - input.device.sample.q[0], target[2] - input.device.sample.q[2]};
  }

  VecQ target{};

 protected:
  void prepare() override {
    if (proxy.mode == ProxyMode::kHeld) proxy.x = map_matrix() * target;
  }
};

VecQ anywhere(std::mt19937_64& random, double size) {
  std::uniform_real_distribution<double> part(-size, size);
  return (VecQ(3) << part(random), part(random), part(random)).finished();
}

TEST(CoupledStiffness, ForceFollowsTheLawWithinLimits) {
  for (const RendererKind renderer : kSubspace) {
    CoupledBench bench(coupled_config(renderer));
    bench.engage();
    std::mt19937_64 random(1);
    int held = 0;
    for (int i = 0; i < 1000; ++i) {
      bench.q() = anywhere(random, 0.006);
      bench.target = anywhere(random, 0.006);
      const TickRecord& record = bench.tick();
      const Vector2d d = bench.d(), tau = law(d);
      ASSERT_LT((Vector2d(record.effort.tau_a) - tau).norm(), 1e-10);
      ASSERT_TRUE((record.effort.tau_a.cwiseAbs().array() <= kLimit.array()).all());
      const bool saturated = tau.norm() < (1.0 - 1e-9) * (kZ * d).norm();
      held += saturated ? 1 : 0;
      LimiterSet expected;
      if (saturated) expected.set(Limiter::kSaturation);
      ASSERT_EQ(record.limiters(), expected) << "and no other limiter has anything to do";
      ASSERT_FALSE(record.effort.actuator_limiters[0].any());
      ASSERT_EQ(record.effort.actuator_limiters[1], expected)
          << "the second actuator is the weaker one";
    }
    EXPECT_GT(held, 200);
    EXPECT_LT(held, 900);
  }
}

TEST(CoupledStiffness, TheGainScalesTheWholeForce) {
  CoupledBench bench(coupled_config(RendererKind::kSubspaceExact));
  bench.target = (VecQ(3) << 0.008, 0.0, 0.004).finished();
  bench.run(250);
  ++bench.input.command.engage_id;
  int ramping = 0;
  for (int i = 0; i < 205; ++i) {
    const TickRecord& record = bench.tick();
    ramping += record.life.gain > 0.0 && record.life.gain < 1.0 ? 1 : 0;
    ASSERT_LT((Vector2d(record.effort.tau_a) - record.life.gain * law(bench.d())).norm(), 1e-10);
    ASSERT_FALSE(record.limiters().has(Limiter::kEnvelope));
  }
  EXPECT_GT(ramping, 150);
}

/// A warm second winding narrows the whole spring; cut off alone it would turn the force.
TEST(CoupledStiffness, WarmWindingReducesTheWholeForce) {
  PipelineConfig config = coupled_config(RendererKind::kSubspaceExact);
  config.ratings.resize(2);
  ThermalParameters motor;
  motor.motor_constant = 0.5;
  motor.winding_resistance = 5.0;
  motor.winding_time = 2.0;
  config.ratings[1].thermal = motor;
  CoupledBench bench(config);
  bench.engage();
  bench.target = (VecQ(3) << 0.004, 0.0, 0.005).finished();
  const Vector2d cold(bench.tick().effort.tau_a);
  EXPECT_TRUE(bench.record.limiters().has(Limiter::kSaturation));
  for (int i = 0; i < 10'000; ++i) {
    const TickRecord& record = bench.tick();
    const Vector2d tau(record.effort.tau_a);
    ASSERT_LT(std::abs(tau[0] * cold[1] - tau[1] * cold[0]), 1e-9) << "it keeps its direction";
  }
  const Vector2d warm(bench.record.effort.tau_a);
  EXPECT_LT(warm.norm(), 0.8 * cold.norm());
  EXPECT_TRUE(bench.record.effort.actuator_limiters[1].has(Limiter::kTemperature));
  EXPECT_FALSE(bench.record.limiters().has(Limiter::kSaturation)) << "one reason, the right one";
  EXPECT_FALSE(bench.record.effort.actuator_limiters[0].any());
}

PipelineConfig guarded(RendererKind renderer, double initial) {
  PipelineConfig config = coupled_config(renderer);
  config.passivity.tank.enabled = true;
  config.passivity.tank.initial = initial;
  config.passivity.observer.enabled = true;
  config.passivity.observer.inertia = VecA::Constant(2, 0.2);
  config.passivity.device_damping = VecA::Constant(2, 1.0);  // 2 b / T > lambda_max = 1272 N/m
  return config;
}

double potential(const Vector2d& d) {
  const double r = kLimit[1] / std::sqrt(kZ(1, 1)), L = std::sqrt(d.dot(kZ * d));
  return L <= r ? 0.5 * L * L : r * L - 0.5 * r * r;
}

/// tests/report/STUDY.md#proxy-step: V jumps by dV, the tank pays it exactly, or the anchor stays
/// on the way.
TEST(CoupledStiffness, TankPaysOrShortensTheSpring) {
  for (const RendererKind renderer : kSubspace) {
    CoupledBench rich(guarded(renderer, 0.05));
    rich.engage();
    rich.target = (VecQ(3) << 0.009, 0.0, -0.002).finished();
    const TickRecord& paid = rich.tick();
    EXPECT_FALSE(paid.effort.passivity.throttled);
    EXPECT_NEAR(paid.effort.passivity.storage, potential(rich.d()), 1e-12);
    EXPECT_NEAR(paid.effort.passivity.tank, 0.05 - potential(rich.d()), 1e-12);

    CoupledBench poor(guarded(renderer, 0.004));
    poor.engage();
    poor.target = rich.target;
    const TickRecord& held = poor.tick();
    EXPECT_TRUE(held.effort.passivity.throttled);
    EXPECT_TRUE(held.limiters().has(Limiter::kEnergyTank));
    EXPECT_EQ(held.effort.passivity.tank, 0.0);
    const Vector2d in_use(held.effort.q_star[0], held.effort.q_star[2]), wanted = poor.d();
    EXPECT_NEAR(potential(in_use), 0.004, 1e-12);
    EXPECT_NEAR(in_use[0] * wanted[1] - in_use[1] * wanted[0], 0.0, 1e-15) << "along s d";
    EXPECT_LT((Vector2d(held.effort.tau_a) - law(in_use)).norm(), 1e-10);
  }
}

/// tests/report/STUDY.md#coupled-stiffness: Z_q = [a^2, r a b; r a b, b^2] with r = 1 - 2^-40,
/// which is exact in double and has condition 2.3e12. The law is written in the small difference 1
/// - r, so that nothing cancels, in long double.
TEST(CoupledStiffness, NearlySingularKeepsTheLaw) {
  constexpr long double a = 30.0L, b = 25.0L, gap = 0x1p-40L;
  const auto ab = static_cast<double>((1.0L - gap) * a * b);
  const Matrix2d Z = (Matrix2d() << 900.0, ab, ab, 625.0).finished();
  const long double radius = std::min(kLimit[0] / a, kLimit[1] / b);
  std::mt19937_64 random(45);
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  for (const RendererKind renderer : kSubspace) {
    CoupledBench bench(coupled_config(renderer, Z));
    bench.engage();
    int saturated = 0;
    for (int i = 0; i < 2000; ++i) {
      // Millimetres in every direction, every other time decimetres along the weak one, (b, -a).
      const double weak = i % 2 == 0 ? 0.01 * part(random) : 0.0;
      bench.q() << 0.006 * part(random), 0.1 * part(random), 0.006 * part(random);
      bench.target << 0.006 * part(random) + 25.0 * weak, 0.1 * part(random),
          0.006 * part(random) - 30.0 * weak;
      const VecA tau = bench.tick().effort.tau_a;
      ASSERT_EQ(bench.record.life.state, LifecycleState::kEngaged);
      const long double d1 = bench.d()[0], d2 = bench.d()[1], along = a * d1 + b * d2;
      const long double length =
          std::sqrt(std::max(0.0L, along * along - 2 * gap * a * b * d1 * d2));
      const long double scale = length > radius ? radius / length : 1.0L;
      ASSERT_NEAR(tau[0], static_cast<double>(scale * (a * along - gap * a * b * d2)), 1e-11);
      ASSERT_NEAR(tau[1], static_cast<double>(scale * (b * along - gap * a * b * d1)), 1e-11);
      ASSERT_LE(std::abs(tau[0]), kLimit[0]);
      ASSERT_LE(std::abs(tau[1]), kLimit[1]);
      const long double u = tau[0] / a, v = tau[1] / b;  // tau^T Z_q^{-1} tau <= rho^2
      ASSERT_LE((u - v) * (u - v) + 2 * gap * u * v,
                radius * radius * (2 * gap - gap * gap) * (1 + 2e-7L));
      saturated += length > radius ? 1 : 0;
    }
    EXPECT_GT(saturated, 250);
    EXPECT_LT(saturated, 1750);
  }
}

}  // namespace
}  // namespace haptic::core
