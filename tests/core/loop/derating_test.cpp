// The stiffness in effect (core/METHOD.md#stiffness-in-effect, Eq. (40)), in virtual time.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <functional>

#include "tests/core/tick/driven.hpp"
#include "tests/support/loop/rails.hpp"
#include "tests/support/vectors.hpp"

namespace haptic::core::derating {
namespace {

using std::chrono::milliseconds;

constexpr double kK = 1500.0, kB = 0.5, kDevice = 2.0;  // N/m, N s/m
constexpr double kPays = 3.0 * kDevice + kB;            // N s/m: of device, hand and rendering

PipelineConfig on_rails(int n = 1) {
  PipelineConfig c = haptic::test::rails(n);
  c.scene.damping = VecA::Constant(n, kB);
  c.scene.staleness.hold_end = milliseconds(400);
  c.scene.staleness.fade_end = milliseconds(500);
  c.derating = true;
  return c;
}

/// A client with a sample every `period_ms`, computed from the probe `late_ms` before it came.
class Late : public test::DrivenPipeline {
 public:
  explicit Late(const PipelineConfig& config = on_rails()) : DrivenPipeline(config) {
    input.device.sample.q = VecQ::Constant(config.kinematics->layout().n_q(), 0.01);
    proxy.x = VecX::Constant(config.kinematics->space().n_x(), 0.008);
    proxy.mode = ProxyMode::kNone;
  }
  const TickRecord& run(int ticks) {
    for (int i = 0; i < ticks; ++i, ++ticks_) {
      tick(true, ticks_ >= begin && ticks_ % period_ms == 0);
    }
    return record;
  }
  const TickRecord& engage() {
    run(700);
    ++input.command.engage_id;
    return run(500);
  }
  [[nodiscard]] double stiffness() const {
    return record.derating.stiffness.size() > 0 ? record.derating.stiffness[0] : kK;
  }
  int period_ms{20}, late_ms{50};
  int begin{200};  ///< tick of the first sample, so that each can say what it was computed from
  std::function<void(ProxySnapshot&)> planes{};

 protected:
  void prepare() override {
    const std::uint64_t now = record.beat.tick + 1;
    const auto late = static_cast<std::uint64_t>(late_ms);
    proxy.seen_at = now > late ? now - late : 0;
    proxy.mode = planes ? ProxyMode::kPlanes : ProxyMode::kHeld;
    if (planes) planes(proxy);
  }

 private:
  int ticks_{0};
};

/// Its samples are 8 ms old when they come; the client speaks in every tick.
class LateBoard : public Late {
 public:
  explicit LateBoard(const PipelineConfig& config = on_rails()) : Late(config) {
    period_ms = 1;
    begin = 0;
  }

 private:
  void prepare() override {
    Late::prepare();
    input.device.sample.time -= milliseconds(8);
  }
};

void fixed_plane(ProxySnapshot& proxy) {
  proxy.planes.normals = MatXQ::Identity(1, 1);
  proxy.planes.offsets = VecX::Constant(1, 0.008);
}

void moving_plane(ProxySnapshot& proxy) {
  fixed_plane(proxy);
  proxy.planes.offsets[0] += proxy.seq % 2 == 0 ? 1e-6 : 0.0;
}

void contact(ProxySnapshot& proxy) {
  moving_plane(proxy);
  proxy.anchored_at = proxy.seen_at;
}

TEST(Derating, HeldProxyIsCappedByDelay) {
  Late quick;  // a short delay counts half
  quick.period_ms = 40;
  quick.late_ms = 12;
  quick.engage();
  EXPECT_NEAR(quick.stiffness(), kPays / (0.0005 + 0.012 / 2 + 0.040 / 8), 1e-9);
  Late loop;
  loop.engage();
  // It comes 50 ms late and is 70 ms old when the next one comes.
  EXPECT_NEAR(loop.stiffness(), kPays / (0.0005 + 0.070 / 4), 1e-9);
  EXPECT_EQ(loop.record.derating.reason, DeratingReason::kHeld);
  EXPECT_EQ(loop.record.derating.delay, milliseconds(70));
  EXPECT_EQ(loop.record.derating.allowed, loop.record.derating.stiffness);
  EXPECT_TRUE(loop.record.limiters().has(Limiter::kDerated));
  EXPECT_NEAR(loop.record.effort.tau_a[0], -0.002 * loop.stiffness(), 1e-12);
}

/// 30 and 70 ms late by turns: 50 and 90 ms old when the next one comes, 70 ms in the mean.
TEST(Derating, FirstSamplesCountAlike) {
  Late loop;
  loop.run(loop.begin);
  for (int sample = 0; sample < 20; ++sample) {
    loop.late_ms = sample % 2 == 0 ? 30 : 70;
    loop.run(loop.period_ms);
  }
  EXPECT_NEAR(loop.stiffness(), kPays / (0.0005 + 0.070 / 4), 0.03 * loop.stiffness());
}

TEST(Derating, LocalLawsKeepTheirBits) {
  const std::pair<int, std::function<void(ProxySnapshot&)>> laws[]{
      {0, {}}, {0, moving_plane}, {100, fixed_plane}, {100, contact}};
  for (const auto& [late_ms, planes] : laws) {
    PipelineConfig without = on_rails();
    without.derating = false;
    Late plain(without), derating;
    for (Late* loop : {&plain, &derating}) {
      loop->late_ms = late_ms;
      loop->planes = planes;
      loop->engage();
    }
    EXPECT_EQ(derating.record.life.state, LifecycleState::kEngaged);
    EXPECT_TRUE(identical(plain.record, derating.record)) << late_ms;
    EXPECT_LT(plain.record.effort.tau_a[0], -1.0);
  }
}

TEST(Derating, PlanesThatChangeAreRemote) {
  Late loop;
  loop.planes = moving_plane;
  loop.engage();
  EXPECT_NEAR(loop.stiffness(), kPays / (0.0005 + 0.070 / 4), 1e-9);
  EXPECT_EQ(loop.record.derating.reason, DeratingReason::kPlanes);
  loop.planes = fixed_plane;
  loop.run(900);
  EXPECT_LT(loop.stiffness(), 0.5 * kK) << "remote for a second after it was";
  loop.run(400);
  EXPECT_EQ(loop.stiffness(), kK);
  EXPECT_FALSE(loop.record.limiters().has(Limiter::kDerated));
}

/// Each changes what an unanchored plane does from sample to sample, not its n and b.
TEST(Derating, AnyNumberMakesPlanesOthers) {
  const std::function<void(ProxySnapshot&, bool)> changes[]{
      [](ProxySnapshot& p, bool odd) { p.planes.compliance = VecX::Constant(1, odd ? 0.1 : 1.0); },
      [](ProxySnapshot& p, bool odd) { p.planes.velocity = VecX::Constant(1, odd ? 0.02 : -0.02); },
      [](ProxySnapshot& p, bool odd) { p.planes.laws = MatXQ::Constant(4, 1, odd ? 1.0 : 2.0); },
      [](ProxySnapshot& p, bool odd) {
        p.planes.curvature = VecX::Constant(1, 1.0);
        p.planes.curved[0] = 1;
        p.x[0] = odd ? 0.008 : 0.0081;
      }};
  for (const auto& change : changes) {
    Late loop;
    loop.planes = [&change](ProxySnapshot& proxy) {
      fixed_plane(proxy);
      change(proxy, proxy.seq % 2 != 0);
    };
    loop.engage();
    EXPECT_EQ(loop.record.derating.reason, DeratingReason::kPlanes);
  }
}

/// 6.5 N s/m at 1500 N/m leave 4.33 ms: of that half a tick, and the age of the samples, are gone.
TEST(Derating, LowPassTakesWhatIsLeft) {
  PipelineConfig config = on_rails();
  config.filter.sensed_lag = milliseconds(6);
  Late alone(config);
  alone.planes = fixed_plane;
  alone.engage();
  EXPECT_NEAR(alone.record.sensed.lag, kPays / kK - 0.0005, 1e-12);
  EXPECT_EQ(alone.stiffness(), kK);
  LateBoard board(config);
  board.planes = fixed_plane;
  board.engage();
  EXPECT_EQ(board.record.sensed.lag, 0.0);
  EXPECT_LT(board.stiffness(), kK);
  Late held(config);
  held.engage();
  EXPECT_EQ(held.record.sensed.lag, 0.006) << "no more than the held proxy is late";
  EXPECT_LT(held.stiffness(), kK);
  config.derating = false;
  Late any(config);
  any.engage();
  EXPECT_EQ(any.record.sensed.lag, 0.006) << "nothing says what the stiffness allows";
}

/// Its part in phase with the rate, at the highest frequency of spring and device; none if that is
/// not known.
TEST(Derating, LowPassedDampingCountsLess) {
  PipelineConfig config = on_rails();
  config.filter.rate_lag = milliseconds(2);
  for (const double inertia : {0.0, 0.05}) {
    config.passivity.device_inertia = inertia > 0.0 ? VecA::Constant(1, inertia) : VecA{};
    Late loop(config);
    loop.engage();
    const double counts = inertia > 0.0 ? kB / (1.0 + kK * 4e-6 / inertia) : 0.0;
    EXPECT_NEAR(loop.stiffness(), (3.0 * kDevice + counts) / (0.0005 + 0.070 / 4), 1e-9);
  }
}

TEST(Derating, HeldBetweenContactsStaysCapped) {
  Late loop;
  loop.engage();
  loop.planes = [](ProxySnapshot& proxy) {
    contact(proxy);
    if (proxy.seq % 2 != 0) proxy.mode = ProxyMode::kHeld;
  };
  loop.run(2000);
  EXPECT_NEAR(loop.stiffness(), kPays / (0.0005 + 0.070 / 4), 1e-9);
}

TEST(Derating, SettingsDoNotLiftTheCap) {
  Late loop;
  loop.engage();
  double before = loop.stiffness();
  for (int ms = 0; ms < 4000; ++ms) {
    if (ms % 500 == 0) {
      loop.input.settings.id += 1;
      loop.input.settings.stiffness[0] = ms % 1000 == 0 ? 150.0 : kK;
    }
    loop.run(1);
    const double K = std::min(loop.stiffness(), loop.input.settings.stiffness[0]);
    ASSERT_LE(K - before, kK / 200 + 1e-9) << ms;
    before = K;
  }
}

TEST(Derating, ReleasedSessionLeavesNothing) {
  Late loop;
  loop.engage();
  ASSERT_LT(loop.stiffness(), kK);
  loop.input.command.lease_held = false;
  loop.begin = 1 << 30;  // it sends nothing any more
  loop.run(2000);
  EXPECT_EQ(loop.record.proxy.mode, ProxyMode::kNone);
  EXPECT_EQ(loop.stiffness(), kK);
  EXPECT_FALSE(loop.record.limiters().has(Limiter::kDerated));
}

TEST(Derating, StiffnessNeverSteps) {
  Late loop;
  loop.late_ms = 0;
  loop.engage();
  double before = loop.stiffness(), least = before;
  EXPECT_EQ(before, kK);
  for (int ms = 0; ms < 8000; ++ms) {
    loop.late_ms = ms < 3000 ? 80 : 0;
    if (ms == 6000) loop.planes = contact;
    loop.run(1);
    ASSERT_LE(std::abs(loop.stiffness() - before), kK / 200 + 1e-9) << ms;
    before = loop.stiffness();
    least = std::min(least, before);
  }
  EXPECT_LT(least, 400.0);
  EXPECT_EQ(before, kK);
}

TEST(Derating, OneLateSampleIsNone) {
  Late loop;
  loop.period_ms = 10;
  loop.late_ms = 2;
  loop.engage();
  loop.late_ms = 100;
  loop.run(20);
  loop.late_ms = 2;
  for (int ms = 0; ms < 500; ++ms) {
    loop.run(1);
    ASSERT_EQ(loop.stiffness(), kK) << ms;
  }
}

TEST(Derating, DevicesDelayCountsWhole) {
  LateBoard loop;
  loop.planes = fixed_plane;
  loop.engage();
  EXPECT_NEAR(loop.stiffness(), kPays / 0.0085, 1e-9);
  EXPECT_EQ(loop.record.derating.reason, DeratingReason::kDevice);
  EXPECT_EQ(loop.record.derating.delay, milliseconds(8));
}

TEST(Derating, UnknownDampingAllowsEverything) {
  PipelineConfig config = on_rails();
  config.passivity.device_damping[0] = 0.0;
  Late loop(config);
  loop.engage();
  EXPECT_EQ(loop.stiffness(), kK);
}

TEST(Derating, NewLeaseIsMeasuredAlone) {
  Late loop;
  loop.engage();
  loop.planes = fixed_plane;
  loop.input.command.tenure = ++loop.proxy.tenure;
  loop.run(500);
  EXPECT_EQ(loop.stiffness(), kK);
}

TEST(Derating, SessionsOwnStiffnessStaysBelow) {
  Late loop;
  loop.engage();
  loop.input.settings.id = 1;
  loop.input.settings.stiffness[0] = 200.0;
  loop.run(300);
  EXPECT_EQ(loop.record.derating.stiffness.size(), 0);
  EXPECT_NEAR(loop.record.effort.tau_a[0], -0.4, 1e-12);
}

TEST(Derating, ErrorBoundFollowsTheStiffness) {
  PipelineConfig whole = on_rails();
  whole.derating = false;
  LateBoard plain(whole), derating;
  for (LateBoard* loop : {&plain, &derating}) {
    loop->planes = [](ProxySnapshot& proxy) {
      contact(proxy);
      proxy.planes.compliance = VecX::Constant(1, 3.0);
      proxy.planes.uncertainty = VecX::Constant(1, 0.2);
      proxy.x = VecX::Constant(1, 0.0095);  // with the joint at 0.01 m, and the plane at 0.008
    };
    loop->engage();
    loop->input.device.sample.q[0] = 0.011;
    loop->run(10);
  }
  const double share = derating.stiffness() / kK;
  EXPECT_LT(share, 0.6);
  ASSERT_EQ(plain.record.effort.error_bound.size(), 1);
  EXPECT_GT(plain.record.effort.error_bound[0], 0.01);
  EXPECT_NEAR(derating.record.effort.error_bound[0], share * plain.record.effort.error_bound[0],
              1e-12);
}

TEST(Derating, CoupledSpringIsCappedWhole) {
  PipelineConfig config = on_rails(2);
  Eigen::Matrix2d Z;
  Z << 1500.0, 900.0, 900.0, 1000.0;
  config.projection.coupling = std::make_shared<const StiffnessCoupling>(Z);
  config.scene.stiffness = config.projection.coupling->scene_stiffness();
  Late loop(config);
  loop.engage();
  const MatAA in_effect = config.projection.coupling->matrix(loop.record.derating.stiffness);
  const Eigen::Matrix2d Z_in_effect = in_effect;
  EXPECT_NEAR(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(Z_in_effect).eigenvalues()[1],
              kPays / 0.018, 1e-9);
}

}  // namespace
}  // namespace haptic::core::derating
