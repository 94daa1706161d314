// The actuator's ratings and the server's force control in the pipeline.
#include <cmath>

#include "finger_bench.hpp"
#include "haptic/core/error.hpp"

namespace haptic::core::test {
namespace {

constexpr double kSofter = 400.0;  // N/m: the press below stays under the force limit

PipelineConfig plain() {
  PipelineConfig c = config_of(RendererKind::kSubspaceExact);
  c.scene.stiffness = VecA::Constant(1, kSofter);
  return c;
}

PipelineConfig rated(const ActuatorRatings& ratings) {
  PipelineConfig c = plain();
  c.ratings = {ratings};
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

double largest_power_out(const std::vector<TickRecord>& records) {
  double largest = 0.0;
  for (const TickRecord& r : records)
    largest = std::max(largest, r.effort.tau_a[0] * r.sensed.q_a_dot[0]);
  return largest;
}

TEST(Ratings, AbsentTheyChangeNothing) {
  Bench bench(plain());
  for (const TickRecord& record : press(bench)) {
    EXPECT_EQ(record.effort.temperature_c.size(), 0);
    EXPECT_EQ(record.effort.drive.size(), 0);
    EXPECT_EQ(record.effort.position.size(), 0);
  }
}

TEST(Ratings, PowerStaysWithinTheRating) {
  Bench free(plain());
  const double unlimited = largest_power_out(press(free));
  ActuatorRatings ratings;
  ratings.power = unlimited / 4.0;
  Bench bench(rated(ratings));
  int held = 0;
  const auto records = press(bench);
  for (const TickRecord& record : records) {
    EXPECT_LE(record.effort.tau_a[0] * record.sensed.q_a_dot[0], ratings.power * (1.0 + 1e-12));
    const bool told = record.limiters().has(Limiter::kPower);
    EXPECT_EQ(told, record.effort.actuator_limiters[0].has(Limiter::kPower));
    held += told ? 1 : 0;
  }
  EXPECT_GT(held, 20);
  EXPECT_NEAR(largest_power_out(records), ratings.power, 1e-9) << "and the rating is used";
}

TEST(Ratings, NothingPushesBeyondTheRatedRate) {
  Bench free(plain());
  double fastest = 0.0;
  for (const TickRecord& r : press(free))
    fastest = std::max(fastest, std::abs(r.sensed.q_a_dot[0]));
  ActuatorRatings ratings;
  ratings.rate = fastest / 2.0;
  Bench bench(rated(ratings));
  int held = 0;
  for (const TickRecord& record : press(bench)) {
    if (std::abs(record.sensed.q_a_dot[0]) >= ratings.rate) {
      EXPECT_LE(record.effort.tau_a[0] * record.sensed.q_a_dot[0], 0.0);
    }
    held += record.limiters().has(Limiter::kRate) ? 1 : 0;
  }
  EXPECT_GT(held, 20);
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

TEST(Ratings, NeedOnePerActuatedDof) {
  PipelineConfig config = plain();
  config.ratings.resize(2);
  EXPECT_THROW(Pipeline{config}, SceneError);
}

}  // namespace
}  // namespace haptic::core::test
