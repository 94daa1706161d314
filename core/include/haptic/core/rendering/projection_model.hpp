#pragma once
/// The part of the projection that the scene fixes, for all renderers: the map, the metric W_x, and
/// a prior if J may lose full column rank (core/METHOD.md#projection-algorithm). Case A, without a
/// prior, or case B, with one, is a property of the scene: a rank decided from tick to tick would
/// step the force.

#include <memory>
#include <optional>

#include "haptic/core/linear/boxed_least_squares.hpp"
#include "haptic/core/linear/stiffness_coupling.hpp"
#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/model/task_metric.hpp"

namespace haptic::core {

/// Case B. The subspace renderers minimise
///   ||x (-) f(q*)||_W^2 + mu ||q*_a - q_a||^2_{Z_q} + mu ||q*_n - q_n^ref||^2_{M_n}
/// with the live q_a and a q_n^ref held from one sample of the proxy to the next. In springs: X
/// pulls q* to the proxy with W / mu, the actuators' own Z_q pull it to where they are, M_n to
/// where the sensed DoFs were. Then tau_a = Z_q (q*_a - q_a) is minus the gradient in q_a of the
/// least energy those springs can have: no cycle of q pumps (core/METHOD.md#projection-algorithm).
/// The metric of the actuated block must be Z_q: with another one the rendered stiffness can have
/// negative eigenvalues (core/METHOD.md#rank-and-prior).
struct Prior {
  double weight{0.0};       ///< mu, 1/J, > 0: mu = 1 counts 1 J in the springs like an error of
                            ///< 1 in ||.||_W
  VecQ sensed_stiffness{};  ///< M_n, n_n, > 0; N/m or N m/rad
};

/// When an iteration ends (core/METHOD.md#projection-algorithm).
struct IterationLimits {
  int max_steps{10};        ///< Gauss-Newton steps per projection
  double tolerance{1e-12};  ///< longest component of a step, relative to the box, that ends it
};

struct ProjectionSettings {
  TaskMetric metric{};
  std::optional<Prior> prior{};
  IterationLimits iteration{};
  /// Coupling of Z_q; null: it is diagonal. It couples DoFs of one block, never of two fingers.
  std::shared_ptr<const StiffnessCoupling> coupling{};
};

class ProjectionModel {
 public:
  /// `kinematics` must outlive the model and its copies. Throws SceneError: X mixes units and there
  /// is no metric; one that ties a rotation to another coordinate; a prior for a map that has an
  /// inverse in closed form; a stiffness that couples fingers; sizes or values that do not fit.
  /// Copies allocate nothing.
  ProjectionModel(const Kinematics& kinematics, ProjectionSettings settings = {});

  /// The same for one block of the map. Throws as the constructor does.
  [[nodiscard]] ProjectionModel of(const MapBlock& block) const;
  /// True if the map has blocks and the metric does not tie them together.
  [[nodiscard]] bool has_blocks() const noexcept { return has_blocks_; }
  /// Those blocks, or the whole map as one. Allocates.
  [[nodiscard]] std::vector<MapBlock> blocks() const;

  [[nodiscard]] const Kinematics& kinematics() const noexcept { return *kinematics_; }
  [[nodiscard]] const DofLayout& layout() const noexcept { return kinematics_->layout(); }
  [[nodiscard]] int n_x() const noexcept { return kinematics_->space().n_x(); }
  [[nodiscard]] const TaskMetric& metric() const noexcept { return settings_.metric; }
  [[nodiscard]] const std::optional<Prior>& prior() const noexcept { return settings_.prior; }
  /// Null if Z_q is diagonal.
  [[nodiscard]] const std::shared_ptr<const StiffnessCoupling>& coupling() const noexcept {
    return settings_.coupling;
  }
  [[nodiscard]] const IterationLimits& iteration() const noexcept { return settings_.iteration; }
  /// Mean of ||W^{1/2} J_a|| (Frobenius) over the workspace: what the paper's Z_x factors out.
  [[nodiscard]] double mean_actuated_jacobian() const noexcept { return mean_J_a_; }
  /// The prior's weight per DoF, sqrt(mu diag(Z_q, M_n)), in the order of q. With a prior only.
  [[nodiscard]] VecQ prior_weight(const VecA& stiffness) const noexcept;
  /// The prior's springs as rows of least squares: of such a weight, pulling p to `target` (n_q).
  void add_prior(const VecQ& weight, const VecQ& target, BoxedLeastSquares& rows) const noexcept;
  /// The sum of squares of those rows at p - target = `stretch`.
  [[nodiscard]] double prior_cost(const VecQ& weight, const VecQ& stretch) const noexcept;

 private:
  const Kinematics* kinematics_;
  ProjectionSettings settings_;
  double mean_J_a_{0.0};
  bool has_blocks_{false};
};

/// Throws SceneError if Z_q cannot be coupled like this on this map: another number of actuated
/// DoFs, or a hand.
void check_coupling(const Kinematics& kinematics, const StiffnessCoupling& coupling);

/// A scene needs a prior if the condition exceeds this in half of the poses of the box: errors of x
/// are then amplified a hundredfold. Measured medians: the hand of
/// tests/report/STUDY.md#larger-devices, known by three points per finger, 264 with two fingers, 19
/// with three, 11 with four; finger exoskeleton 3.
inline constexpr double kWellConditioned = 100.0;

/// Throws SceneError if the scene needs a prior and has none. It needs one if the condition of J,
/// weighed and equilibrated, exceeds kWellConditioned in at least half of the poses of the box (
/// core/METHOD.md#hand-without-prior: without one the two-fingered hand answers 3 mm of noise with
/// hundreds of radians).
void require_rank(const ProjectionModel& model);

}  // namespace haptic::core
