#include "tests/bench/free_fingers.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "haptic/core/tick/probe_completion.hpp"
#include "tests/bench/paired.hpp"
#include "tests/bench/tick_input.hpp"
#include "tests/bench/tick_p50.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/equal_fingers.hpp"

namespace haptic::bench {

namespace {

using core::VecQ;
using core::VecX;

constexpr int kFingers = 5;
constexpr int kPoses = 512;
constexpr double kStopPip = 25 * kDegree;

/// Five fingers that close and open together. The plane of the first bears in half of the poses.
struct Hand {
  std::shared_ptr<const core::Kinematics> map = equal_fingers(kFingers);
  std::vector<VecQ> q{};
  std::vector<VecX> x{};

  Hand() {
    for (int i = 0; i < kPoses; ++i) {
      const double phase = 2 * M_PI * i / kPoses;
      VecX at(map->space().n_x());
      for (int f = 0; f < kFingers; ++f) {
        at.segment<2>(2 * f) << (22 + 8 * std::sin(phase)) * kDegree,
            (25 + 9 * std::sin(phase + 0.3)) * kDegree;
      }
      VecQ pose;
      if (map->inverse(at, pose) != core::InverseStatus::kExact) std::abort();
      q.push_back(pose);
      x.push_back(at);
    }
  }
};

core::TickInput tick_input(const Hand& hand, const core::PipelineConfig& config, int i) {
  const auto at = static_cast<std::size_t>(i % kPoses);
  core::TickInput input = held_tick(config, i, hand.q[at], hand.x[at]);
  input.proxy.mode = core::ProxyMode::kPlanes;
  input.proxy.planes.normals.setZero(hand.map->space().n_x(), 1);
  input.proxy.planes.normals(1, 0) = 1.0;
  input.proxy.planes.offsets.setConstant(1, kStopPip);
  return input;
}

/// `ask_all`: with f of the fingers that the tick left out, which makes the record of a tick that
/// leaves none out.
double tick_p50(const Hand& hand, core::RendererKind kind, bool ask_all) {
  const core::PipelineConfig config = pressing_config(hand.map, kind);
  core::Pipeline pipeline(config);
  core::ProbeCompletion completion(*hand.map);
  double force = 0.0;
  const double p50 = bench::tick_p50([&](int i) { return tick_input(hand, config, i); },
                                     [&](const core::TickInput& input) {
                                       core::TickRecord record = pipeline.tick(input);
                                       if (ask_all) completion.complete(record);
                                       force = std::max(force, std::abs(record.tau_elastic[0]));
                                     });
  if (force == 0.0) std::abort();  // a tick without force would be a flattering figure
  return p50;
}

/// Largest difference in rad between the completed x_probe and f at the record's q, and how many
/// fingers a tick left out on average once engaged.
void print_errors(const Hand& hand) {
  const core::PipelineConfig config = pressing_config(hand.map, core::RendererKind::kSubspaceExact);
  core::Pipeline pipeline(config);
  core::ProbeCompletion completion(*hand.map);
  double worst = 0.0;
  int left_out = 0, ticks = 0;
  VecX x;
  core::MatXQ J;
  for (int i = 0; i < 4000; ++i) {
    core::TickRecord record = pipeline.tick(tick_input(hand, config, i));
    completion.complete(record);
    if (i < 1000) continue;
    ++ticks;
    for (core::BlockSet set = record.unprobed; set != 0; set >>= 1) left_out += (set & 1u) != 0;
    static_cast<void>(hand.map->evaluate(record.q, x, J));
    worst = std::max(worst, (x - record.x_probe).cwiseAbs().maxCoeff());
  }
  std::printf(
      "# fingers left out of a tick %.3g of %d; x_probe of the completed record: off by %.3g rad\n",
      static_cast<double>(left_out) / ticks, kFingers, worst);
}

}  // namespace

void print_free_fingers() {
  const Hand hand;
  for (const core::RendererKind kind :
       {core::RendererKind::kSubspaceLinear, core::RendererKind::kSubspaceExact}) {
    const std::string of = std::string(core::name(kind)) + " hand of 5, 1 on a plane";
    print(compare(
        "tick " + of + ", free fingers left out p50", "f of every finger asked for", "ns",
        [&] { return tick_p50(hand, kind, false); }, [&] { return tick_p50(hand, kind, true); },
        0.0));
  }
  print_errors(hand);
}

}  // namespace haptic::bench
