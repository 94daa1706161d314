#pragma once
/// The direction guard (core/METHOD.md#forces-at-the-finger): the elastic force must not point away
/// from the proxy as the finger feels it, Eq. (15): tau_a^T (S J^+ dx) >= 0. Otherwise the guard
/// withholds all of it. It also withholds a force that pushes into a contact,
/// tau_a^T (S J^+ out_i) < 0: a share that grows with the contact's depth, and all of it deeper
/// than contact_band(), as in the rule per contact. EasedForce decides how fast the force goes and
/// comes. A map with several fingers is judged by the sum alone. Each block of a map is evaluated
/// by itself; the J of a block with dx = 0 is not read.

#include <memory>
#include <vector>

#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/rendering/projection.hpp"
#include "haptic/core/rendering/projection_model.hpp"

namespace haptic::core {

class DirectionGuard {
 public:
  /// The model is copied; its kinematics must outlive the guard. `stiffness` (n_a; size 0: ones),
  /// with the model's coupling, chooses the solution if J does not have full column rank, as in Eq.
  /// (8).
  explicit DirectionGuard(const ProjectionModel& model, const VecA& stiffness = {});
  /// Share of tau_a (n_a) that is allowed: 1 if it points towards the proxy and out of every
  /// contact, or dx = 0. One linearised solve per block.
  [[nodiscard]] double share(const Probe& probe, const VecX& dx, const VecA& tau_a) noexcept;

 private:
  struct Block {
    MapBlock at;
    ProjectionModel model;
    LeastSquares solver;
    double band{0.0};  ///< depth from which a contact takes no push
    bool by_joint{false};
    VecX out{};
    VecX dx{};  ///< W^{1/2} dx
    MatXQ J{};  ///< W^{1/2} J
    VecA stiffness{};
  };

  VecA stiffness_;
  std::vector<Block> blocks_{};  ///< one per block, or the whole map
};

}  // namespace haptic::core
