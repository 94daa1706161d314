#include "tests/report/bound_study.hpp"

#include <algorithm>
#include <chrono>
#include <limits>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/rendering/renderer.hpp"
#include "tests/report/bound_bodies.hpp"
#include "tests/support/loop/pipeline_loop.hpp"
#include "tests/support/loop/rails.hpp"
#include "tests/support/plane_set.hpp"

namespace haptic::report {
namespace {

using core::VecX;
using Eigen::Vector2d;

constexpr double kEngage_s = 1.5, kBegin_s = 2.0, kEnd_s = 4.0;
constexpr double kRounding = 5e-6;  // N, of two solutions of one problem

double between(test::Random& random, double lowest, double highest) {
  return lowest + (highest - lowest) * random.uniform();
}
double log_between(test::Random& random, double lowest, double highest) {
  return lowest * std::pow(highest / lowest, random.uniform());
}
Vector2d direction(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

/// The motion of the device: a sum of two sines in each coordinate of the point, or of the joints.
struct Motion {
  Vector2d centre{}, across{};
  double amplitude[2]{}, turn[2]{}, phase[2]{};
  [[nodiscard]] VecX at(double t) const {
    const Vector2d normal(-across[1], across[0]);
    return centre + amplitude[0] * std::sin(turn[0] * t + phase[0]) * across +
           amplitude[1] * std::sin(turn[1] * t + phase[1]) * normal;
  }
};

bool of_finger(BoundKind kind) {
  return kind == BoundKind::kPads || kind == BoundKind::kStroked;
}

struct Run {
  BoundWorld world{};
  Motion motion{};
  core::PipelineConfig pipeline{};
  double uncertainty{0.0};
  double sooner{0.5};   ///< part of the round trip after which the sample was really computed
  bool nearest{false};  ///< the simulation follows its minimum, even if another one is less
  test::ClientSettings client{};
};

void put_bodies(BoundKind kind, test::Random& random, BoundWorld& world) {
  const bool several = kind == BoundKind::kDiscs || kind == BoundKind::kMoving;
  const int count =
      several ? 1 + static_cast<int>(random.next() % 3) + (kind == BoundKind::kDiscs ? 1 : 0)
      : kind == BoundKind::kFlat ? 1 + static_cast<int>(random.next() % 3)
                                 : 1;
  for (int i = 0; i < count; ++i) {
    BoundBody body;
    body.stiffness = log_between(random, 100.0, 20000.0);
    body.radius = kind == BoundKind::kFlat ? std::numeric_limits<double>::infinity()
                                           : log_between(random, 0.010, 0.060);
    const double angle = between(random, 0.0, 2.0 * M_PI);
    if (world.finger) {
      body.centre = {between(random, 0.02, 0.05), -between(random, 0.03, 0.05)};
      body.radius = between(random, 0.015, 0.03);
    } else if (body.flat()) {
      body.normal = direction(angle);
      body.centre = -between(random, 0.0, 0.005) * body.normal;
    } else {
      const double depth = between(random, -0.005, 0.010);
      body.centre = (body.radius - depth) * direction(angle);
    }
    if (moves(kind) || (body.flat() && random.next() % 2 == 0)) {
      body.velocity = log_between(random, 0.002, 0.1) * direction(between(random, 0.0, 2.0 * M_PI));
      body.centre -= 0.5 * (kBegin_s + kEnd_s) * body.velocity;
    }
    world.bodies.push_back(body);
  }
}

Run drawn(BoundKind kind, std::uint64_t number) {
  test::Random random(static_cast<std::uint64_t>(kind) + 1, number);
  Run run;
  run.world.finger = of_finger(kind);
  run.pipeline = test::rails(2);
  if (run.world.finger) {
    core::PipelineConfig& c = run.pipeline;
    c = test::rails(1);
    c.kinematics = core::make_finger_exoskeleton({});
    c.device.q_lower = (core::VecQ(2) << -0.01, -1.6).finished();
    c.device.q_upper = (core::VecQ(2) << 0.06, 1.6).finished();
    run.world.coupling = 0.6;
  } else {
    run.world.coupling = test::Rails::coupling;
  }
  run.pipeline.scene.staleness.hold_end = std::chrono::milliseconds(200);
  run.pipeline.scene.staleness.fade_end = std::chrono::milliseconds(300);
  put_bodies(kind, random, run.world);
  run.uncertainty = random.next() % 2 == 0 ? 0.0 : between(random, 0.05, 0.3);
  for (BoundBody& body : run.world.bodies) {
    body.told = 1.0 / (1.0 + between(random, -run.uncertainty, run.uncertainty));
  }
  run.nearest = random.next() % 2 == 0;
  run.sooner = random.uniform();
  const double most = log_between(random, 0.01, run.world.finger ? 0.2 : 0.4);  // m/s
  run.motion.across = direction(between(random, 0.0, 2.0 * M_PI));
  for (int k = 0; k < 2; ++k) {
    const double hz = log_between(random, 0.2, 3.0);
    run.motion.turn[k] = 2.0 * M_PI * hz;
    run.motion.amplitude[k] = std::min(0.020, most / run.motion.turn[k]);
    run.motion.phase[k] = between(random, 0.0, 2.0 * M_PI);
  }
  if (run.world.finger) {
    run.motion.centre << between(random, 0.3, 0.8), between(random, 0.3, 0.9);
    for (double& amplitude : run.motion.amplitude) amplitude *= 12.0;  // rad
  } else {
    run.motion.centre = between(random, 0.0, 0.006) * direction(between(random, 0.0, 6.28));
  }
  using core::RendererKind;
  constexpr RendererKind kKinds[]{RendererKind::kSubspaceLinear, RendererKind::kPerContact};
  run.pipeline.scene.renderer = kKinds[random.next() % 2];
  test::ClientSettings& client = run.client;
  client.mode = core::ProxyMode::kPlanes;
  client.rate_hz = log_between(random, 20.0, 250.0);
  client.delay_s = random.next() % 4 == 0 ? 0.0 : log_between(random, 0.004, 0.2);
  client.delay_growth = random.next() % 3 == 0 ? between(random, 0.0, 0.05) : 0.0;
  client.lost = random.next() % 3 == 0 ? 0.1 : 0.0;
  client.disorder = random.next() % 4 == 0;
  client.seed = random.next();
  return run;
}

/// The force of the truth: the renderer's own, on the proxy and the contacts of the bodies.
class Truth {
 public:
  explicit Truth(const Run& run)
      : run_(run), map_(*run.pipeline.kinematics), rule_(run.pipeline.scene.renderer, map_) {}

  [[nodiscard]] core::VecA force(double t, const core::VecQ& q, bool& touched) {
    VecX p, dx;
    core::MatXQ J;
    static_cast<void>(map_.evaluate(q, p, J));
    if (x_.size() == 0) x_ = p;
    x_ = run_.nearest ? run_.world.from(t, p, x_) : run_.world.least(t, p, x_);
    std::array<BoundGap, BoundWorld::kMostGaps> gaps;
    const std::size_t count = run_.world.gaps(t, x_, gaps);
    core::Contacts contacts;
    contacts.into.resize(2, static_cast<Eigen::Index>(count));
    contacts.depth.resize(static_cast<Eigen::Index>(count));
    touched = false;
    for (std::size_t k = 0; k < count; ++k) {
      const BoundGap& gap = gaps[k];
      const auto i = static_cast<Eigen::Index>(k);
      const double length = gap.g.norm();
      contacts.into.col(i) = -gap.g / length;
      contacts.depth[i] = -(gap.phi + gap.g.dot(p - x_)) / length;
      touched = touched || gap.phi < 0.0;
    }
    if (!touched) return core::VecA::Zero(map_.layout().n_a());
    dx = x_ - p;
    core::Projection out;
    rule_.project({q, p, J, {&contacts}}, x_, dx, run_.pipeline.scene.stiffness, true, out);
    return run_.pipeline.scene.stiffness.cwiseProduct(map_.layout().select(out.q_star - q));
  }

 private:
  const Run& run_;
  const core::Kinematics& map_;
  core::Renderer rule_;
  VecX x_{};
};

std::function<void(test::Frame&)> simulation(const Run& run) {
  const double near =
      0.5 * (run.client.delay_s + run.client.delay_growth * kEnd_s + 2.0 / run.client.rate_hz);
  return [&run, near, x = VecX()](test::Frame& frame) mutable {
    // The estimate of the source's clock is half the round trip; it may be any part of it.
    const double t = frame.seen_s + 2.0 * run.sooner * (frame.computed_s - frame.seen_s);
    if (x.size() == 0) x = frame.x_probe;
    x = run.nearest ? run.world.from(t, frame.x_probe, x) : run.world.least(t, frame.x_probe, x);
    frame.x = x;
    std::vector<client::Plane> planes = run.world.told(t, x, near + 0.01, run.uncertainty);
    frame.walls = test::plane_set(planes, 2);
    frame.anchored = !planes.empty();
  };
}

}  // namespace

std::string_view name(BoundKind kind) noexcept {
  constexpr std::string_view kNames[]{"disc",         "discs", "flat",
                                      "moving_discs", "pads",  "pads_on_moving_disc"};
  return kNames[static_cast<std::size_t>(kind)];
}

void BoundRuns::add(const BoundRuns& other) {
  runs += other.runs;
  broken_runs += other.broken_runs;
  ticks += other.ticks;
  known += other.known;
  broken += other.broken;
  if (other.worst > worst) {
    worst = other.worst;
    worst_run = other.worst_run;
  }
  errors.insert(errors.end(), other.errors.begin(), other.errors.end());
  bounds.insert(bounds.end(), other.bounds.begin(), other.bounds.end());
}

BoundRuns bound_run(BoundKind kind, std::uint64_t number) {
  Run run = drawn(kind, number);
  run.client.simulate = simulation(run);
  test::PipelineLoop loop(run.pipeline, run.client, test::Rails::damping);
  Truth truth(run);
  const core::Kinematics& map = *run.pipeline.kinematics;
  BoundRuns found{.runs = 1, .worst_run = number};
  core::VecQ q;
  for (int k = 1; k <= 1000 * kEnd_s; ++k) {
    const double t = 1e-3 * k;
    if (k == 1000 * kEngage_s) loop.engage();
    const VecX aim = run.motion.at(t);
    if (run.world.finger) {
      static_cast<void>(map.inverse(aim, q));
    } else {
      q = aim;
    }
    const core::TickRecord& record = loop.tick(q);
    bool touched = false;
    const core::VecA shadow = truth.force(t, q, touched);
    if (t < kBegin_s || record.life.gain == 0.0) continue;
    const core::VecA off = (record.effort.tau_elastic - record.life.gain * shadow).cwiseAbs();
    const core::VecA& bound = record.effort.error_bound;
    found.ticks += touched ? 1 : 0;
    if (bound.size() == 0) continue;
    found.known += touched ? 1 : 0;
    const double beyond = (off - bound).maxCoeff();
    if (beyond > kRounding) ++found.broken;
    found.worst = std::max(found.worst, beyond);
    if (!touched || k % 5 != 0) continue;
    found.errors.push_back(off.maxCoeff());
    found.bounds.push_back(bound.maxCoeff());
  }
  found.broken_runs = found.broken > 0 ? 1 : 0;
  return found;
}

}  // namespace haptic::report
