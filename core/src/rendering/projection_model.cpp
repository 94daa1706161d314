#include "haptic/core/rendering/projection_model.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "haptic/core/error.hpp"
#include "haptic/core/linear/least_squares.hpp"

namespace haptic::core {

namespace {

constexpr int kPoses = 256;

/// The i-th point of the box by additive recurrence with square roots of primes: covers it evenly,
/// the same poses on every machine.
VecQ pose(const std::vector<DofSpec>& dofs, int i) {
  constexpr int kPrimes[kMaxQ] = {2,  3,  5,  7,  11, 13, 17, 19, 23, 29, 31, 37,
                                  41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89};
  VecQ q(static_cast<Eigen::Index>(dofs.size()));
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    double whole = 0.0;
    const double part = std::modf((i + 0.5) * std::sqrt(static_cast<double>(kPrimes[k])), &whole);
    q[static_cast<Eigen::Index>(k)] = dofs[k].lower + part * (dofs[k].upper - dofs[k].lower);
  }
  return q;
}

/// Calls `visit` with J at the poses of the box where the map has a value; says how many there
/// were.
template <typename Visit>
int for_poses(const Kinematics& kinematics, Visit visit) {
  int found = 0;
  VecX x;
  MatXQ J;
  for (int i = 0; i < kPoses; ++i) {
    if (kinematics.evaluate(pose(kinematics.dofs(), i), x, J) != MapStatus::kOk) continue;
    visit(J);
    ++found;
  }
  return found;
}

/// A quaternion and its negative are one rotation: what ties its parts to anything else would
/// change sign with the way it happens to be written.
void require_rotations_apart(const ConfigurationSpace& space, const TaskMetric& metric) {
  for (const int first : space.quaternions()) {
    if (metric.separates(first, 4)) continue;
    throw SceneError("task metric: W ties the rotation of coordinates " + std::to_string(first) +
                     " to " + std::to_string(first + 3) +
                     " to other coordinates: must be 0 there, because q and -q are one rotation");
  }
}

void check(const Kinematics& kinematics, const ProjectionSettings& settings) {
  const ConfigurationSpace& space = kinematics.space();
  if (settings.metric.is_identity() && space.mixes_units()) {
    throw SceneError("task metric: must be given, because X has coordinates in m and in rad");
  }
  if (!settings.metric.is_identity() && settings.metric.n_x() != space.n_x()) {
    throw SceneError("task metric for " + std::to_string(settings.metric.n_x()) +
                     " coordinates: must be for " + std::to_string(space.n_x()));
  }
  require_rotations_apart(space, settings.metric);
  if (settings.iteration.max_steps < 1 || !(settings.iteration.tolerance > 0.0)) {
    throw SceneError("iteration: max_steps must be >= 1, tolerance > 0");
  }
  if (settings.coupling) check_coupling(kinematics, *settings.coupling);
  if (!settings.prior) return;
  const Prior& prior = *settings.prior;
  if (!(prior.weight > 0.0 && std::isfinite(prior.weight))) {
    throw SceneError("prior.weight = " + std::to_string(prior.weight) + ": must be finite and > 0");
  }
  VecQ q = VecQ::Zero(kinematics.layout().n_q());
  if (kinematics.inverse(VecX::Zero(space.n_x()), q) != InverseStatus::kNotOffered) {
    throw SceneError("prior: must be absent, because this map has an inverse in closed form");
  }
  const int n_n = kinematics.layout().n_n();
  if (prior.sensed_stiffness.size() != n_n) {
    throw SceneError("prior.sensed_stiffness has " + std::to_string(prior.sensed_stiffness.size()) +
                     " values: must have one per sensed DoF, " + std::to_string(n_n));
  }
  for (int i = 0; i < n_n; ++i) {
    if (prior.sensed_stiffness[i] > 0.0 && std::isfinite(prior.sensed_stiffness[i])) continue;
    throw SceneError("prior.sensed_stiffness[" + std::to_string(i) + "] = " +
                     std::to_string(prior.sensed_stiffness[i]) + ": must be finite and > 0");
  }
}

/// The map knows the mean of ||J_a|| over its own workspace, which is not a box; the metric changes
/// it by a factor, and that varies little.
double weighed_mean(const Kinematics& kinematics, const TaskMetric& metric) {
  const double mean = kinematics.mean_actuated_jacobian();
  if (metric.is_identity()) return mean;
  double factors = 0.0;
  int counted = 0;
  MatXQ scratch;
  for_poses(kinematics, [&](const MatXQ& J) {
    const double plain = actuated_norm(J, kinematics.layout());
    if (!(plain > 0.0)) return;
    factors += actuated_norm(metric.weighed(J, scratch), kinematics.layout()) / plain;
    ++counted;
  });
  return counted > 0 ? mean * factors / counted : mean;
}

}  // namespace

void check_coupling(const Kinematics& kinematics, const StiffnessCoupling& coupling) {
  if (coupling.n_a() != kinematics.layout().n_a()) {
    throw SceneError("stiffness matrix of " + std::to_string(coupling.n_a()) +
                     " rows: must have one per actuated DoF, " +
                     std::to_string(kinematics.layout().n_a()));
  }
  if (kinematics.blocks().size() > 1 || !kinematics.mechanisms().empty()) {
    throw SceneError(
        "stiffness matrix: must be diagonal for a hand, whose fingers are devices of their own: "
        "one "
        "would be pushed by what another touches");
  }
}

ProjectionModel::ProjectionModel(const Kinematics& kinematics, ProjectionSettings settings)
    : kinematics_(&kinematics), settings_(std::move(settings)) {
  check(kinematics, settings_);
  mean_J_a_ = weighed_mean(kinematics, settings_.metric);
  for (const MapBlock& block : kinematics.blocks()) {
    has_blocks_ = settings_.metric.separates(block.first_x, block.n_x());
    if (!has_blocks_) break;
  }
}

std::vector<MapBlock> ProjectionModel::blocks() const {
  if (has_blocks_) return blocks_or_whole(*kinematics_);
  return {{kinematics_, 0, 0, 0}};
}

ProjectionModel ProjectionModel::of(const MapBlock& block) const {
  ProjectionSettings settings = settings_;
  settings.metric = settings_.metric.of(block.first_x, block.n_x());
  if (settings_.prior) {
    const int first_n = block.first_q - block.first_a;  // blocks come in the order of q and of q_a
    settings.prior->sensed_stiffness =
        settings_.prior->sensed_stiffness.segment(first_n, block.kinematics->layout().n_n());
  }
  return {*block.kinematics, std::move(settings)};
}

VecQ ProjectionModel::prior_weight(const VecA& stiffness) const noexcept {
  const DofLayout& map = layout();
  VecQ weight(map.n_q());
  for (int i = 0; i < map.n_a(); ++i) {
    weight[map.actuated(i)] = std::sqrt(settings_.prior->weight * stiffness[i]);
  }
  for (int i = 0; i < map.n_n(); ++i) {
    weight[map.sensed(i)] =
        std::sqrt(settings_.prior->weight * settings_.prior->sensed_stiffness[i]);
  }
  return weight;
}

void ProjectionModel::add_prior(const VecQ& weight, const VecQ& target,
                                BoxedLeastSquares& rows) const noexcept {
  const StiffnessCoupling* const coupling = settings_.coupling.get();
  if (coupling == nullptr) {
    rows.add_diagonal(weight, target);
    return;
  }
  const DofLayout& map = layout();
  MatXQ springs = MatXQ::Zero(map.n_q(), map.n_q());
  for (int i = 0; i < map.n_n(); ++i) springs(map.sensed(i), map.sensed(i)) = weight[map.sensed(i)];
  for (int i = 0; i < map.n_a(); ++i) {
    for (int j = i; j < map.n_a(); ++j) {
      springs(map.actuated(i), map.actuated(j)) = coupling->factor(i, j) * weight[map.actuated(j)];
    }
  }
  rows.add(springs, springs.lazyProduct(target));
}

double ProjectionModel::prior_cost(const VecQ& weight, const VecQ& stretch) const noexcept {
  if (settings_.coupling == nullptr) return weight.cwiseProduct(stretch).squaredNorm();
  VecQ rows = weight.cwiseProduct(stretch);
  const DofLayout& map = layout();
  VecA actuated = map.select(rows);
  settings_.coupling->stretch(actuated);
  for (int i = 0; i < map.n_a(); ++i) rows[map.actuated(i)] = actuated[i];
  return rows.squaredNorm();
}

void require_rank(const ProjectionModel& model) {
  if (model.prior()) return;
  LeastSquares solver(model.n_x(), model.layout());
  const VecX dx = VecX::Zero(model.n_x());
  const VecA Z_q = VecA::Ones(model.layout().n_a());
  MatXQ scratch;
  int worse = 0;
  const int found = for_poses(model.kinematics(), [&](const MatXQ& J) {
    solver.solve(model.metric().weighed(J, scratch), dx, Z_q);
    worse += !(solver.condition() <= kWellConditioned);
  });
  if (2 * worse < found || found == 0) return;
  throw SceneError("prior: must be given, because the condition of J exceeds " +
                   std::to_string(static_cast<int>(kWellConditioned)) + " in " +
                   std::to_string(worse) + " of " + std::to_string(found) +
                   " poses: " + std::to_string(model.layout().n_n()) + " sensed DoFs, " +
                   std::to_string(model.n_x()) +
                   " coordinates, which do not determine q: say which springs hold the rest");
}

}  // namespace haptic::core
