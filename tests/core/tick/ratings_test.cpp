// The actuator's ratings in the pipeline.
#include <algorithm>
#include <cmath>
#include <ranges>

#include "finger_bench.hpp"

namespace haptic::core::test {
namespace {

constexpr double kSofter = 400.0;  // N/m: the press below stays under the force limit

PipelineConfig plain() {
  PipelineConfig c = config_of(RendererKind::kSubspaceExact);
  c.scene.stiffness = VecA::Constant(1, kSofter);
  return c;
}

/// Presses into a held proxy and leaves it again, the joints at up to 5 rad/s.
std::vector<TickRecord> press(Bench& bench) {
  std::vector<TickRecord> records;
  bench.engage();
  for (int i = 1; i <= 400; ++i) {
    const double bend = 0.4 * (1.0 - std::cos(2.0 * M_PI * i / 400.0)) / 2.0;
    bench.put(joints(0.5 + bend, 0.5 + bend));
    records.push_back(bench.tick());
  }
  return records;
}

double power_out(const TickRecord& r) {
  return r.effort.tau_a[0] * r.sensed.q_a_dot[0];
}
double largest_power_out(const std::vector<TickRecord>& records) {
  return std::ranges::max(records | std::views::transform(power_out));
}

TEST(Ratings, PowerStaysWithinTheRating) {
  PipelineConfig config = plain();
  Bench free(config);
  const auto unlimited = press(free);
  const Effort& without = unlimited.back().effort;
  EXPECT_EQ(without.temperature_c.size() + without.drive.size() + without.position.size(), 0);
  ActuatorRatings ratings;
  ratings.power = largest_power_out(unlimited) / 4.0;
  config.ratings = {ratings};
  Bench bench(config);
  int held = 0;
  const auto records = press(bench);
  for (const TickRecord& record : records) {
    EXPECT_LE(power_out(record), ratings.power * (1.0 + 1e-12));
    const bool told = record.limiters().has(Limiter::kPower);
    EXPECT_EQ(told, record.effort.actuator_limiters[0].has(Limiter::kPower));
    held += told ? 1 : 0;
  }
  EXPECT_GT(held, 20);
  EXPECT_NEAR(largest_power_out(records), ratings.power, 1e-9) << "and the rating is used";
}

TEST(Ratings, WarmWindingReducesForceAndReports) {
  ActuatorRatings ratings;
  ratings.thermal = ThermalParameters{};
  ratings.thermal->motor_constant = 1.0;
  ratings.thermal->winding_resistance = 5.0;
  ratings.thermal->winding_time = 2.0;
  PipelineConfig config = config_of(RendererKind::kSubspaceExact);
  config.ratings = {ratings};
  Bench bench(config);
  TickRecord record = bench.engage();
  ASSERT_EQ(record.effort.temperature_c.size(), 1);
  EXPECT_LE(record.effort.temperature_c[0], ratings.thermal->derate_from_c);
  const double lasting = std::sqrt(75.0 / 5.0);  // N: 25 C to 100 C over 5 K/W
  bench.put(joints(0.8, 0.8));                   // and stay: some 9 N
  for (int i = 0; i < 50; ++i) record = bench.tick();
  const double cold = std::abs(record.effort.tau_a[0]);
  for (int i = 0; i < 10'000; ++i) record = bench.tick();
  EXPECT_GT(cold, 2.0 * lasting);
  EXPECT_NEAR(std::abs(record.effort.tau_a[0]), lasting, 0.02 * cold);
  EXPECT_TRUE(record.limiters().has(Limiter::kTemperature));
  EXPECT_FALSE(record.limiters().has(Limiter::kSaturation)) << "one reason, the right one";
  EXPECT_LE(record.effort.temperature_c[0], ratings.thermal->limit_c);
}

}  // namespace
}  // namespace haptic::core::test
