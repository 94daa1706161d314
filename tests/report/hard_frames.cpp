#include "tests/report/hard_frames.hpp"

#include <algorithm>
#include <cmath>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/report/chosen_linkage.hpp"
#include "tests/report/values.hpp"
#include "tests/support/dense_oracle.hpp"
#include "tests/support/link/random.hpp"

namespace haptic::report {
namespace {

using core::MatXQ;
using core::VecQ;
using core::VecX;

constexpr std::uint64_t kSeed = 19;
constexpr double kSlack = 1e-9;      // of the room of a slider's end
constexpr double kBeyond = 0.05;     // of a DoF's range
constexpr double kArmReach = 0.30;   // m, both links
constexpr double kArmHeight = 0.10;  // m, of the shoulder

double range_of(const core::DofSpec& dof) {
  return dof.upper - dof.lower;
}

VecQ boxed(const core::Kinematics& map, VecQ q) {
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const core::DofSpec& dof = map.dofs()[static_cast<std::size_t>(i)];
    q[i] = std::clamp(q[i], dof.lower, dof.upper);
  }
  return q;
}

bool sliders_hold(const core::Kinematics& map, const VecQ& q) {
  for (const core::Mechanism& mechanism : map.mechanisms()) {
    core::Constraints constraints;
    if (mechanism.kinematics->constraints(q.segment(mechanism.first_q, 2), constraints) !=
        core::MapStatus::kOk) {
      return false;
    }
    for (const core::Constraint& constraint : constraints) {
      if (!(constraint.room >= -kSlack)) return false;
    }
  }
  return true;
}

class Poses {
 public:
  Poses(std::shared_ptr<const core::Kinematics> map, std::uint64_t set)
      : map_(std::move(map)), random_(kSeed, set) {}
  [[nodiscard]] const core::Kinematics& map() const { return *map_; }
  double between(double a, double b) { return a + (b - a) * random_.uniform(); }
  /// Anywhere in the box where the mechanism can be; within `share` of the box about `near`.
  VecQ any(double share = 1.0, const VecQ& near = {}) {
    VecQ q(map_->layout().n_q());
    do {
      for (Eigen::Index i = 0; i < q.size(); ++i) {
        const core::DofSpec& dof = map_->dofs()[static_cast<std::size_t>(i)];
        const double half = 0.5 * share * range_of(dof);
        const double middle = near.size() > 0 ? near[i] : 0.5 * (dof.lower + dof.upper);
        q[i] = std::clamp(middle + between(-half, half), dof.lower, dof.upper);
      }
    } while (!sliders_hold(*map_, q) || !image(q));
    return q;
  }
  /// f(q) to x(); false if there is none.
  bool image(const VecQ& q) { return map_->evaluate(q, x_, J_) == core::MapStatus::kOk; }
  [[nodiscard]] const VecX& x() const { return x_; }
  [[nodiscard]] double condition(const VecQ& q) {
    if (!image(q)) return 0.0;
    Eigen::MatrixXd scaled = J_;
    for (Eigen::Index k = 0; k < scaled.cols(); ++k) {
      scaled.col(k) *= range_of(map_->dofs()[static_cast<std::size_t>(k)]);
    }
    return oracle::condition(scaled);
  }

 private:
  std::shared_ptr<const core::Kinematics> map_;
  test::Random random_;
  VecX x_{};
  MatXQ J_{};
};

void add(HardFrames& frames, const VecQ& q, const VecX& x, double least) {
  frames.q.push_back(q);
  frames.x.push_back(x);
  frames.least.push_back(least);
}

/// Search in the box from q, in random directions so that it gets along a slider's end: no
/// derivative, and nothing of the methods that are compared.
double descended(const core::Kinematics& map, const VecX& x, VecQ q) {
  constexpr double kFinest = 1e-10;
  constexpr int kDirections = 60;
  test::Random random(kSeed);
  double best = residual_inside(map, q, x);
  for (double step = 0.02; step > kFinest; step *= 0.5) {
    for (int i = 0; i < kDirections; ++i) {
      VecQ along(q.size());
      for (double& part : along) part = random.normal();
      along *= step / along.norm();
      for (Eigen::Index k = 0; k < q.size(); ++k) {
        along[k] *= range_of(map.dofs()[static_cast<std::size_t>(k)]);
      }
      // Goes on as long as it gets better, with strides that double.
      for (double stride = 1.0;; stride *= 2.0) {
        const VecQ trial = boxed(map, VecQ(q + stride * along));
        const double residual = residual_inside(map, trial, x);
        if (!(residual < best)) break;
        best = residual;
        q = trial;
        i = 0;
      }
    }
  }
  return best;
}

/// The least residual over a grid of the whole box, descended from its five best.
double exhausted(const core::Kinematics& map, const VecX& x) {
  const int n = static_cast<int>(map.dofs().size());
  const int points = n == 2 ? 160 : 36;
  std::vector<std::pair<double, VecQ>> best;
  int total = 1;
  for (int i = 0; i < n; ++i) total *= points;
  VecQ q(n);
  for (int k = 0; k < total; ++k) {
    for (int i = 0, rest = k; i < n; ++i, rest /= points) {
      const core::DofSpec& dof = map.dofs()[static_cast<std::size_t>(i)];
      q[i] = dof.lower + range_of(dof) * (rest % points) / (points - 1);
    }
    const double residual = residual_inside(map, q, x);
    if (std::isnan(residual) || (best.size() == 5 && residual >= best.back().first)) continue;
    if (best.size() == 5) best.pop_back();
    const auto worse = std::find_if(best.begin(), best.end(),
                                    [&](const auto& one) { return one.first > residual; });
    best.insert(worse, {residual, q});
  }
  double least = HUGE_VAL;
  for (const auto& [residual, from] : best) least = std::min(least, descended(map, x, from));
  return least;
}

HardFrames random_frames(HardFrames frames, int count) {
  Poses poses(frames.kinematics, 1);
  frames.what = "random";
  for (int i = 0; i < count; ++i) {
    const VecQ q = poses.any();
    poses.any();
    add(frames, q, poses.x(), 0.0);
  }
  return frames;
}

HardFrames near_singular(HardFrames frames, int count) {
  constexpr int kOf = 100;  // poses, of which one is taken
  Poses poses(frames.kinematics, 2);
  frames.what = "near_singular";
  std::vector<std::pair<double, VecQ>> found;
  for (int i = 0; i < kOf * count; ++i) {
    const VecQ q = poses.any();
    found.emplace_back(-poses.condition(q), q);
  }
  const auto by_condition = [](const auto& a, const auto& b) { return a.first < b.first; };
  std::partial_sort(found.begin(), found.begin() + count, found.end(), by_condition);
  for (int i = 0; i < count; ++i) {
    const VecQ& q = found[static_cast<std::size_t>(i)].second;
    poses.any(kBeyond, q);
    add(frames, q, poses.x(), 0.0);
  }
  return frames;
}

HardFrames at_the_box(HardFrames frames, int count) {
  Poses poses(frames.kinematics, 3);
  frames.what = "at_the_box";
  const int n = static_cast<int>(poses.map().dofs().size());
  while (static_cast<int>(frames.q.size()) < count) {
    VecQ beyond = poses.any();
    const int i = std::min(n - 1, static_cast<int>(poses.between(0, n)));
    const core::DofSpec& dof = poses.map().dofs()[static_cast<std::size_t>(i)];
    const bool low = poses.between(0, 1) < 0.5;
    beyond[i] = low ? dof.lower - kBeyond * range_of(dof) : dof.upper + kBeyond * range_of(dof);
    const VecQ edge = boxed(poses.map(), beyond);
    if (!sliders_hold(poses.map(), edge) || !poses.image(edge)) continue;
    if (!poses.image(beyond)) continue;
    const VecX x = poses.x();
    add(frames, poses.any(0.2, edge), x, exhausted(poses.map(), x));
  }
  return frames;
}

}  // namespace

double residual_inside(const core::Kinematics& map, VecQ q, const VecX& x) {
  if (!q.allFinite()) return NAN;
  q = boxed(map, q);
  VecX at, away;
  if (map.position(q, at) != core::MapStatus::kOk || !sliders_hold(map, q)) return NAN;
  map.space().difference(x, at, away);
  return away.norm();
}

core::SerialChainParameters hard_arm() {
  using core::JointKind;
  core::SerialChainParameters arm;
  arm.joints = {
      {"turret", JointKind::kRevolute, true, "", {}, {0, 0, 1}, -2.6, 2.6},
      {"shoulder", JointKind::kRevolute, true, "", {{0, 0, kArmHeight}, {}}, {0, 1, 0}, -1.7, 1.7},
      {"elbow", JointKind::kRevolute, false, "", {{0.16, 0, 0}, {}}, {0, 1, 0}, -2.4, 2.4}};
  arm.outputs = {{"tip", "", core::OutputKind::kPoint, {{0.14, 0, 0}, {}}}};
  return arm;
}

std::vector<HardFrames> hard_frames_of_finger(int count) {
  const HardFrames frames{.map = "finger",
                          .unit = "rad",
                          .kinematics = core::make_finger_exoskeleton(chosen_linkage())};
  const core::Kinematics& map = *frames.kinematics;
  std::vector<HardFrames> all{random_frames(frames, count), near_singular(frames, count),
                              at_the_box(frames, count)};
  Poses poses(frames.kinematics, 4);
  VecQ q_star;
  const auto out_of_reach = [&] {
    VecX x(2);
    do {
      x << poses.between(-60, 140) * kDegree, poses.between(-60, 140) * kDegree;
    } while (map.inverse(x, q_star) != core::InverseStatus::kUnreachable);
    return x;
  };
  HardFrames unreachable = frames, ties = frames;
  unreachable.what = "unreachable";
  for (int i = 0; i < count; ++i) {
    const VecX x = out_of_reach();
    add(unreachable, poses.any(), x, exhausted(map, x));
  }
  // A tie: the nearest pose jumps between two proxies that are next to each other.
  ties.what = "at_ties";
  const auto apart = [&](const VecQ& a, const VecQ& b) {
    double most = 0.0;
    for (Eigen::Index i = 0; i < a.size(); ++i) {
      most =
          std::max(most, std::abs(a[i] - b[i]) / range_of(map.dofs()[static_cast<std::size_t>(i)]));
    }
    return most;
  };
  constexpr double kJump = 0.05, kNextTo = 1e-9;
  for (int tries = 0; tries < 200 * count && static_cast<int>(ties.q.size()) < count; ++tries) {
    VecX a = out_of_reach();
    VecQ q_a = q_star;
    VecX b = out_of_reach();
    VecQ q_b = q_star;
    while ((b - a).norm() > kNextTo && apart(q_a, q_b) > kJump) {
      const VecX middle = 0.5 * (a + b);
      if (map.inverse(middle, q_star) != core::InverseStatus::kUnreachable) break;
      const bool left = apart(q_star, q_a) > apart(q_star, q_b);
      (left ? b : a) = middle;
      (left ? q_b : q_a) = q_star;
    }
    if ((b - a).norm() > kNextTo || !(apart(q_a, q_b) > kJump)) continue;
    add(ties, poses.any(), a, exhausted(map, a));
  }
  all.push_back(std::move(unreachable));
  all.push_back(std::move(ties));
  return all;
}

std::vector<HardFrames> hard_frames_of_arm(int count) {
  const HardFrames frames{
      .map = "arm", .unit = "m", .kinematics = core::make_serial_chain(hard_arm())};
  std::vector<HardFrames> all{random_frames(frames, count), near_singular(frames, count),
                              at_the_box(frames, count)};
  Poses poses(frames.kinematics, 4);
  HardFrames unreachable = frames, ties = frames;
  unreachable.what = "unreachable";
  ties.what = "at_ties";
  for (int i = 0; i < count; ++i) {
    VecX out(3);
    out << poses.between(-1, 1), poses.between(-1, 1), poses.between(-1, 1);
    VecX x = out * (poses.between(1.02, 2.0) * kArmReach / out.norm());
    x[2] += kArmHeight;
    add(unreachable, poses.any(), x, exhausted(poses.map(), x));
    // On the turret's axis every angle of the turret is as good.
    VecX tie = VecX::Zero(3);
    const double side = poses.between(0, 1) < 0.5 ? -1.0 : 1.0;
    tie[2] = kArmHeight + side * poses.between(0.3, 0.95) * kArmReach;
    add(ties, poses.any(), tie, exhausted(poses.map(), tie));
  }
  all.push_back(std::move(unreachable));
  all.push_back(std::move(ties));
  return all;
}

}  // namespace haptic::report
