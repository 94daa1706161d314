/// core/METHOD.md#map-without-a-value, core/METHOD.md#an-hour-of-ticks and
/// core/METHOD.md#guarded-press: the whole tick.
#include <algorithm>
#include <cmath>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/report/finger_press.hpp"
#include "tests/report/hard_cases/hard_case.hpp"
#include "tests/report/hard_cases/loop.hpp"
#include "tests/support/allocation_guard.hpp"

namespace haptic::report {
namespace {

using core::VecA;
using core::VecQ;
using core::VecX;

/// Where |D| <= h1 the linkage cannot close.
void map_fails(Outcomes& out) {
  constexpr double kZ = 100.0;
  Loop loop(core::RendererKind::kSubspaceExact, kZ);
  const VecX x = VecX::Constant(2, 27 * kDegree);
  const VecQ q =
      (VecQ(2) << 0.015864, -14.806 * kDegree).finished();  // core/METHOD.md#finger-linkage:
                                                            // (30, 30) deg
  const core::TickRecord before = loop.engage(q, x);
  const VecQ beyond = (VecQ(2) << 0.02, -101 * kDegree).finished();
  const core::TickRecord record = loop.tick(beyond, x);
  const double expected = kZ * (before.effort.q_star[0] - beyond[0]);
  const bool told = record.anchor.projection == core::ProjectionStatus::kMapFailed;
  const bool kept = record.effort.q_star == before.effort.q_star;
  out.push_back({"17", "the map has no value at q: q* kept, tau = Z_q (q*_a - q_a) live, reported",
                 said("q* %s, tau %.4f of %.4f N, status %s", kept ? "kept" : "lost",
                      record.effort.tau_elastic[0], expected,
                      std::string(core::name(record.anchor.projection)).c_str()),
                 told && kept && std::abs(record.effort.tau_elastic[0] - expected) < 1e-9});
}

void an_hour(Outcomes& out) {
  constexpr int kTicks = 3'600'000;
  std::uint64_t allocations = 0;
  bool finite = true, engaged = true;
  const auto finger = core::make_finger_exoskeleton({});
  std::vector<VecQ> poses;
  for (int i = 0; i < 1000; ++i) {
    const double phase = 2 * M_PI * i / 1000;
    VecQ q;
    static_cast<void>(finger->inverse((VecX(2) << (24 + 10 * std::sin(phase)) * kDegree,
                                       (30 + 12 * std::sin(phase + 0.3)) * kDegree)
                                          .finished(),
                                      q));
    poses.push_back(q);
  }
  Loop loop(core::RendererKind::kSubspaceExact, 1500.0);
  const VecX stop = (VecX(2) << 20 * kDegree, 25 * kDegree).finished();
  static_cast<void>(loop.engage(poses[0], stop));
  const test::AllocationGuard guard;
  for (int i = 0; i < kTicks; ++i) {
    const core::TickRecord record = loop.tick(poses[static_cast<std::size_t>(i % 1000)], stop);
    finite = finite && std::isfinite(record.effort.tau_a[0]);
    engaged = engaged && record.life.state == core::DeviceState::kEngaged;
  }
  allocations = guard.allocations();
  out.push_back(
      {"24", "3.6e6 ticks in virtual time: no allocation, every force finite",
       said("%llu allocations, %s, %s", static_cast<unsigned long long>(allocations),
            finite ? "finite" : "not finite", engaged ? "engaged throughout" : "force lost"),
       allocations == 0 && finite && engaged});
}

void felt_at_the_finger(Outcomes& out) {
  constexpr Pair kStops[] = {{18, kNoStop}, {18, kNoStop}, {kNoStop, 25}, {18, 25}};
  constexpr double kStiffness[] = {1500, 6000, 1500, 1500};
  double against = 0.0, deeper = -HUGE_VAL, work = -HUGE_VAL;
  for (int r = 0; r < 4; ++r) {
    Press press;
    press.stop_deg = kStops[r];
    press.stiffness = kStiffness[r];
    press.direction_guard = true;
    press.force = false;
    const double none = report::press(press).max_penetration_deg;
    press.force = true;
    for (const core::RendererKind kind : kMethods) {
      press.method = kind;
      const Felt felt = report::press(press, [&](const PressTick& tick) {
        const double dx1 = std::min(0.0, press.stop_deg.first - tick.x_deg.first) * kDegree;
        const double dx2 = std::min(0.0, press.stop_deg.second - tick.x_deg.second) * kDegree;
        against = std::min(against, tick.tau_x.first * dx1 + tick.tau_x.second * dx2);
      });
      deeper = std::max(deeper, felt.max_penetration_deg - none);
      work = std::max(work, felt.work);
    }
  }
  out.push_back({"26",
                 "the rows of core/METHOD.md#forces-at-the-finger, every renderer with the guard: "
                 "tau_x.dx >= 0 in every "
                 "tick, no more penetration than without force (0.5 deg), no work into the "
                 "finger",
                 said("tau_x.dx >= %.0e N m; at most %+.2f deg; at most %+.2f mJ", against, deeper,
                      1e3 * work),
                 against >= -1e-9 && deeper <= 0.5 && work <= 1e-6});
}

}  // namespace

void loop_cases(Outcomes& out) {
  map_fails(out);
  an_hour(out);
  felt_at_the_finger(out);
}

}  // namespace haptic::report
