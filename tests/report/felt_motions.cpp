// Motions of the hands of felt_study.hpp: windows of recordings, and random reaches and returns.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "haptic/core/error.hpp"
#include "hw/motion/minimum_jerk.hpp"
#include "hw/motion/pchip.hpp"
#include "tests/report/felt_study.hpp"
#include "tests/support/link/random.hpp"

namespace haptic::report {
namespace {

using Aim = std::function<Eigen::Vector2d(double)>;
using Eigen::Vector2d;

constexpr double kLook_s = 0.01;         // between the samples by which a motion is judged
constexpr double kRoom = 6.0 * kDegree;  // that a motion must have towards its object
constexpr double kDeepest = 15.0 * kDegree;
constexpr int kTries = 200;

std::vector<Vector2d> looks(const Aim& aim) {
  std::vector<Vector2d> all;
  for (double t = 0.0; t <= kFeltSeconds; t += kLook_s) all.push_back(aim(t));
  return all;
}

bool reached(const core::Kinematics& finger, const Aim& aim) {
  core::VecQ q = core::VecQ::Zero(finger.layout().n_q());
  for (const Vector2d& x : looks(aim)) {
    if (finger.inverse(core::VecX(x), q) != core::InverseStatus::kExact) return false;
  }
  return true;
}

/// How much further than its first pose a motion goes along n, and where.
struct Way {
  double room{0.0};
  Vector2d at{Vector2d::Zero()};
};
Way way_along(const std::vector<Vector2d>& path, const Vector2d& n) {
  Way way{0.0, path.front()};
  for (const Vector2d& x : path) {
    if (n.dot(x - path.front()) <= way.room) continue;
    way = {n.dot(x - path.front()), x};
  }
  return way;
}

/// An object that the motion does not touch at first and passes 30 to 80 % of its way into.
/// Returns false if the motion is too small for one.
bool put_object(test::Random& random, FeltTrajectory& trajectory) {
  const std::vector<Vector2d> path = looks(trajectory.aim);
  const auto between = [&](double a, double b) { return a + (b - a) * random.uniform(); };
  for (int tries = 0; tries < kTries; ++tries) {
    const double angle = between(0.0, 2.0 * std::numbers::pi), radius = between(25, 60) * kDegree;
    const double share = between(0.3, 0.8), second = between(0.3, 0.8);
    const bool both = random.uniform() < 0.25;
    const Vector2d n =
        both ? Vector2d(Vector2d::UnitX()) : Vector2d(std::cos(angle), std::sin(angle));
    const Way way = way_along(path, n), other = way_along(path, Vector2d::UnitY());
    if (way.room < kRoom || (both && other.room < kRoom)) continue;
    const double depth = std::min(share * way.room, kDeepest);
    if (trajectory.round) {
      const Vector2d centre = trajectory.centre = way.at + n * (radius - depth);
      trajectory.object = [centre, radius](const core::VecX& x_probe) {
        Vector2d out = Vector2d(x_probe[0], x_probe[1]) - centre;
        const double distance = out.norm();
        out = distance > 0.0 ? Vector2d(out / distance) : Vector2d(Vector2d::UnitX());
        core::PlaneSet planes;
        planes.normals = -out;
        planes.offsets.setConstant(1, -out.dot(centre) - radius);
        return planes;
      };
      return true;
    }
    core::PlaneSet walls;
    walls.normals.resize(2, both ? 2 : 1);
    walls.offsets.resize(both ? 2 : 1);
    walls.normals.col(0) = n;
    walls.offsets[0] = n.dot(way.at) - depth;
    if (both) {
      walls.normals.col(1) = Vector2d::UnitY();
      walls.offsets[1] = other.at[1] - std::min(second * other.room, kDeepest);
    }
    trajectory.object = [walls](const core::VecX&) { return walls; };
    return true;
  }
  return false;
}

/// Both objects of a motion; nothing if it is too small for either.
void add(FeltMotions& all, const Aim& aim, bool recorded, std::uint64_t seed, int& motions) {
  const int motion = all.recorded_motions + all.made_motions;
  std::vector<FeltTrajectory> pair;
  for (const bool round : {false, true}) {
    test::Random random(seed, static_cast<std::uint64_t>(2 * motion + (round ? 1 : 0)));
    FeltTrajectory one{motion, recorded, round, aim};
    if (!put_object(random, one)) return;
    pair.push_back(std::move(one));
  }
  all.trajectories.insert(all.trajectories.end(), pair.begin(), pair.end());
  ++motions;
}

/// A recording's windows, one after another.
void add_recording(const core::Kinematics& finger, const std::string& file, std::uint64_t seed,
                   std::size_t count, FeltMotions& all) {
  const hw::MotionTable table = flexed_recording(file);
  const auto mcp = std::make_shared<hw::Pchip>(table.time_s, table.values[0]);
  const auto pip = std::make_shared<hw::Pchip>(table.time_s, table.values[1]);
  for (double from = 0.0; from + kFeltSeconds <= mcp->last(); from += kFeltSeconds) {
    if (all.trajectories.size() >= count) return;
    const Aim aim = [mcp, pip, from](double t) {
      return Vector2d((*mcp)(from + t), (*pip)(from + t));
    };
    bool gap = false;
    for (std::size_t i = 1; i < table.time_s.size(); ++i) {
      gap = gap || (table.time_s[i] > from && table.time_s[i - 1] < from + kFeltSeconds &&
                    hw::is_gap(table.time_s[i - 1], table.time_s[i]));
    }
    const int before = all.recorded_motions;
    if (!gap && reached(finger, aim)) add(all, aim, true, seed, all.recorded_motions);
    if (all.recorded_motions == before) ++all.left_out;
  }
}

/// To a random aim and back, the PIP joint up to 0.1 s behind the MCP or before it.
Aim reach_and_return(test::Random& random) {
  const auto between = [&](double a, double b) { return a + (b - a) * random.uniform(); };
  const Vector2d start(between(3, 30) * kDegree, between(3, 40) * kDegree);
  const Vector2d aim(between(15, 75) * kDegree, between(15, 85) * kDegree);
  const double rise = between(0.25, 0.65), back = between(0.25, 0.5);
  const double leaves = kFeltSeconds - back - between(0.0, 0.15), lag = between(-0.1, 0.1);
  return [=](double t) {
    const auto way = [&](double at) {
      return hw::minimum_jerk(at / rise) - hw::minimum_jerk((at - leaves) / back);
    };
    const Vector2d share(way(t - std::max(0.0, -lag)), way(t - std::max(0.0, lag)));
    return Vector2d(start + share.cwiseProduct(aim - start));
  };
}

}  // namespace

hw::MotionTable flexed_recording(const std::string& file) {
  constexpr double kLowest = 3.0 * kDegree;
  hw::MotionTable table = hw::read_motion_csv(file, {hw::joint_angle_columns()});
  for (std::vector<double>& joint : table.values) {
    const double lowest = *std::min_element(joint.begin(), joint.end());
    for (double& angle : joint) angle += std::max(0.0, kLowest - lowest);
  }
  return table;
}

FeltMotions felt_motions(const core::Kinematics& finger, const std::vector<std::string>& recordings,
                         int count, std::uint64_t seed) {
  FeltMotions all;
  const auto wanted = static_cast<std::size_t>(count);
  for (const std::string& file : recordings) add_recording(finger, file, seed, wanted, all);
  test::Random random(seed);
  for (int tries = 0; all.trajectories.size() < wanted; ++tries) {
    if (tries > kTries * count) throw core::SceneError("felt: no motion fits the linkage's reach");
    const Aim aim = reach_and_return(random);
    if (reached(finger, aim)) add(all, aim, false, seed, all.made_motions);
  }
  all.trajectories.resize(wanted);
  return all;
}

}  // namespace haptic::report
