#include "tests/bench/free_fingers.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "haptic/core/tick/pipeline.hpp"
#include "haptic/core/tick/probe_completion.hpp"
#include "tests/bench/p50_of_ticks.hpp"
#include "tests/bench/paired.hpp"
#include "tests/bench/tick_input.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/pressing_hand.hpp"

namespace haptic::bench {

namespace {

using core::VecQ;
using core::VecX;

constexpr int kFingers = 5;
constexpr int kPoses = 512;
constexpr double kStopPip = 25 * kDegree;

/// Five fingers that close and open together. The plane of the first bears in every pose.
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
            (37 + 9 * std::sin(phase + 0.3)) * kDegree;
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

/// What the row is about; a tick of another kind would be a flattering figure.
bool presses_with_one_of_five(const core::TickRecord& record) {
  constexpr core::BlockSet kAllButTheFirst = 0b11110;
  return record.state == core::DeviceState::kEngaged && record.tau_elastic[0] != 0.0 &&
         record.unprobed == kAllButTheFirst;
}

constexpr int kRising = 1000;  // ticks until the force is on

/// `in_the_tick`: f of the fingers that it leaves out is asked for as part of it.
double tick_p50(const Hand& hand, core::RendererKind kind, bool in_the_tick) {
  const core::PipelineConfig config = pressing_config(hand.map, kind);
  core::Pipeline pipeline(config);
  core::ProbeCompletion completion(*hand.map);
  int ticks = 0;
  bool as_meant = true;
  const double p50 = p50_of_ticks([&](int i) { return tick_input(hand, config, i); },
                                  [&](const core::TickInput& input) {
                                    core::TickRecord record = pipeline.tick(input);
                                    if (in_the_tick) completion.complete(record);
                                    if (++ticks > kRising) {
                                      as_meant = as_meant && presses_with_one_of_five(record);
                                    }
                                  });
  if (!as_meant) std::abort();
  return p50;
}

/// Ticks of 3000 whose completed record has f(q) in x_probe, and in x of the free fingers, to the
/// bit.
int complete_records(const Hand& hand, core::RendererKind kind) {
  const core::PipelineConfig config = pressing_config(hand.map, kind);
  core::Pipeline pipeline(config);
  core::ProbeCompletion completion(*hand.map);
  const Eigen::Index free = hand.map->space().n_x() - 2;
  int complete = 0;
  VecX x;
  core::MatXQ J;
  for (int i = 0; i < kRising + 3000; ++i) {
    core::TickRecord record = pipeline.tick(tick_input(hand, config, i));
    completion.complete(record);
    if (i < kRising) continue;
    const bool closes = hand.map->evaluate(record.q, x, J) == core::MapStatus::kOk;
    const bool same = x == record.x_probe && x.tail(free) == record.x.tail(free);
    complete += closes && same && presses_with_one_of_five(record) ? 1 : 0;
  }
  return complete;
}

}  // namespace

void print_free_fingers() {
  const Hand hand;
  for (const core::RendererKind kind :
       {core::RendererKind::kSubspaceLinear, core::RendererKind::kSubspaceExact}) {
    const std::string tick = "tick " + std::string(core::name(kind)) + " hand of 5 with 4 free p50";
    print(compare(
        tick, "f of the free ones in the tick", "ns", [&] { return tick_p50(hand, kind, false); },
        [&] { return tick_p50(hand, kind, true); }, 0.0));
    std::printf("# its completed records have f(q) of every finger: %d of 3000\n",
                complete_records(hand, kind));
  }
}

}  // namespace haptic::bench
