/// haptic-report scaling: what a tick of a hand costs, by fingers declared and fingers in contact.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "haptic/core/error.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "tests/bench/single_calls.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/values.hpp"
#include "tests/support/percentile.hpp"
#include "tests/support/pressing_hand.hpp"

namespace haptic::report {
namespace {

using core::VecA;
using core::VecQ;
using core::VecX;

constexpr int kFingers = 5;  // of the largest hand
constexpr int kFrame = 16;   // ticks between the client's frames: 60 Hz
constexpr int kPoses = 512;  // of a grasp that repeats
constexpr double kStopMcp = 18 * kDegree, kStopPip = 25 * kDegree;

/// Kind of proxy by which a scene renders contact.
struct Way {
  const char* name;
  core::ProxyMode mode;
  bool guarded;  ///< direction guard, tank and observer: what planes want
                 ///< (core/METHOD.md#local-models)
};
constexpr Way kWays[]{{"held", core::ProxyMode::kHeld, false},
                      {"planes", core::ProxyMode::kPlanes, false},
                      {"planes_guarded", core::ProxyMode::kPlanes, true}};

/// A hand in virtual time: its first fingers press on stops and move. The others are idle: with a
/// held proxy they rest at a pose that the proxy shares; with planes they move freely, for none is
/// theirs.
class Hand {
 public:
  Hand(core::RendererKind kind, const Way& way, int declared, int in_contact)
      : map_(equal_fingers(declared)),
        pipeline_(config(kind, way.guarded, map_)),
        mode_(way.mode),
        in_contact_(in_contact) {
    record_poses(in_contact);
    input_.settings = pipeline_.config().scene;
    input_.device.armed = true;
    input_.command.tenure = 1;
    input_.command.lease_held = true;
    for (int i = 0; i < 700; ++i) {
      if (i == 260) ++input_.command.engage_id;
      state_ = pipeline_.tick(prepare(), proxy_).life.state;
    }
    if (state_ != core::LifecycleState::kEngaged) {
      throw core::SceneError("scaling: the hand did not engage; a tick without force is no figure");
    }
  }

  /// ns, of `ticks` single ticks.
  double median_tick(int ticks) {
    return bench::p50_of_calls(
        0, ticks, [this](int) -> const core::TickInput& { return prepare(); },
        [this](const core::TickInput& input) {
          force_ += pipeline_.tick(input, proxy_).effort.tau_a[0];
        });
  }

 private:
  static core::PipelineConfig config(core::RendererKind kind, bool guarded,
                                     const std::shared_ptr<const core::Kinematics>& map) {
    const int n_a = map->layout().n_a();
    core::PipelineConfig c = pressing_config(map, kind);
    c.scene.direction_guard = guarded;
    c.passivity.tank.enabled = guarded;
    c.passivity.observer.enabled = guarded;
    c.passivity.device_damping = VecA::Constant(n_a, 2.0);
    c.passivity.observer.inertia = VecA::Constant(n_a, 0.05);
    return c;
  }

  void record_poses(int in_contact) {
    const int n_x = map_->space().n_x();
    for (int i = 0; i < kPoses; ++i) {
      const double phase = 2 * M_PI * i / kPoses;
      VecX at(n_x), proxy(n_x);
      for (int f = 0; f < n_x / 2; ++f) {
        const bool moves = f < in_contact || mode_ == core::ProxyMode::kPlanes;
        at[2 * f] = (22 + (moves ? 8 * std::sin(phase) : -6)) * kDegree;
        at[2 * f + 1] = (30 + (moves ? 9 * std::sin(phase + 0.3) : -6)) * kDegree;
        proxy[2 * f] = std::min(at[2 * f], kStopMcp);
        proxy[2 * f + 1] = std::min(at[2 * f + 1], kStopPip);
      }
      VecQ q;
      if (map_->inverse(at, q) != core::InverseStatus::kExact) {
        throw core::SceneError("scaling: a pose of the grasp is out of reach");
      }
      q_.push_back(q);
      // A finger at rest is where its proxy is, to the bit: the client saw it there.
      VecX seen;
      core::MatXQ J;
      static_cast<void>(map_->evaluate(q, seen, J));
      for (int k = 2 * in_contact; k < n_x; ++k) proxy[k] = seen[k];
      x_.push_back(proxy);
    }
  }
  const core::TickInput& prepare() {
    const auto k = static_cast<std::size_t>(tick_ % kPoses);
    input_.now += std::chrono::milliseconds(1);
    input_.device.fresh = true;
    ++input_.device.sample.seq;
    input_.device.sample.time = input_.now;
    input_.device.sample.q = q_[k];
    if (tick_++ % kFrame == 0) {
      const bool outside = ++proxy_.seq == 1 && mode_ == core::ProxyMode::kHeld;
      proxy_.mode = outside ? core::ProxyMode::kFree : mode_;
      proxy_.tenure = 1;
      if (proxy_.seq == 1) proxy_.gapless_since = input_.now;
      ++proxy_.gapless_samples;
      proxy_.born = input_.now;
      proxy_.x = x_[k];
      if (mode_ != core::ProxyMode::kPlanes) return input_;
      proxy_.planes.normals.setZero(proxy_.x.size(), in_contact_);  // one on each PIP joint
      proxy_.planes.offsets.setConstant(in_contact_, kStopPip);
      for (int f = 0; f < in_contact_; ++f) proxy_.planes.normals(2 * f + 1, f) = 1.0;
    }
    return input_;
  }

  std::shared_ptr<const core::Kinematics> map_;
  core::Pipeline pipeline_;
  core::ProxyMode mode_;
  int in_contact_;
  core::TickInput input_{};
  core::ProxySnapshot proxy_{};
  core::LifecycleState state_{};
  std::vector<VecQ> q_{};
  std::vector<VecX> x_{};
  int tick_{0};
  double force_{0.0};
};

struct Row {
  core::RendererKind kind;
  const Way* way;
  int declared, in_contact;
  std::unique_ptr<Hand> hand{};
  std::vector<double> medians{};
};

std::vector<Row> rows_of(int fingers) {
  std::vector<Row> rows;
  for (const core::RendererKind kind :
       {core::RendererKind::kSubspaceLinear, core::RendererKind::kSubspaceExact}) {
    for (const Way& way : kWays) {
      for (int declared = 1; declared <= fingers; ++declared) {
        for (int in_contact = 0; in_contact <= declared; ++in_contact) {
          rows.push_back({kind, &way, declared, in_contact,
                          std::make_unique<Hand>(kind, way, declared, in_contact)});
        }
      }
    }
  }
  return rows;
}

const Row& row_of(const std::vector<Row>& rows, const Row& like, int declared, int in_contact) {
  return *std::find_if(rows.begin(), rows.end(), [&](const Row& one) {
    return one.kind == like.kind && one.way == like.way && one.declared == declared &&
           one.in_contact == in_contact;
  });
}

/// An idle declared finger in % of one in contact, with one contact throughout: what the other
/// declared fingers add, against what contacts add. Turn by turn, so that a turn in which the
/// machine was slow counts as one; the median of the turns.
double idle_share(const std::vector<Row>& rows, const Row& like) {
  const std::vector<double>& one = row_of(rows, like, 1, 1).medians;
  const std::vector<double>& idle = row_of(rows, like, kFingers, 1).medians;
  const std::vector<double>& contact = row_of(rows, like, kFingers, kFingers).medians;
  std::vector<double> shares;
  for (std::size_t turn = 0; turn < one.size(); ++turn) {
    shares.push_back(100.0 * (idle[turn] - one[turn]) / (contact[turn] - one[turn]));
  }
  return test::percentile(shares, 0.5);
}

void print_scaling(int ticks) {
  constexpr int kTurns = 20;
  std::vector<Row> rows = rows_of(kFingers);
  for (int turn = 0; turn < kTurns; ++turn) {
    for (Row& one : rows) one.medians.push_back(one.hand->median_tick(ticks));
  }
  row("method", "proxy", "fingers_declared", "fingers_in_contact", "tick_ns", "idle_share_pct");
  for (const Row& one : rows) {
    row(core::name(one.kind), one.way->name, one.declared, one.in_contact,
        test::percentile(one.medians, 0.5),
        one.declared == kFingers ? idle_share(rows, one) : std::nan(""));
  }
}

}  // namespace

void add_scaling(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("scaling", "Tick cost against fingers declared and fingers in contact");
  command->footer(
      "A hand of independent fingers, its first ones pressing on stops and moving, the others "
      "idle: at rest with a held proxy, moving freely with planes, alone or with direction guard, "
      "tank and observer (planes_guarded); frames at 60 Hz. Median tick in ns; the rows take "
      "turns, "
      "20 times.\nidle_share_pct: an idle declared finger (against one finger less), in % of a "
      "finger in contact (against the same finger not declared); from the rows with one contact "
      "and "
      "with all, turn by turn, median.");
  auto ticks = std::make_shared<int>(1000);
  command->add_option("--ticks", *ticks, "ticks per turn and row (1000)")
      ->check(CLI::Range(16, 1'000'000));
  command->callback([ticks] { print_scaling(*ticks); });
}

}  // namespace haptic::report
