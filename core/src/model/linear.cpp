#include "haptic/core/model/linear.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "drawing_parts.hpp"
#include "haptic/core/error.hpp"

namespace haptic::core {

namespace {

class Linear final : public Kinematics {
 public:
  explicit Linear(const LinearMap& map)
      : Kinematics(map.dofs, ConfigurationSpace(map.coordinates)),
        A_(map.A),
        x_0_(map.x_0.size() == 0 ? VecX(VecX::Zero(space_.n_x())) : map.x_0) {
    if (A_.rows() != space_.n_x() || A_.cols() != layout_.n_q()) {
      throw SceneError("A is " + std::to_string(A_.rows()) + " x " + std::to_string(A_.cols()) +
                       ": must be " + std::to_string(space_.n_x()) + " x " +
                       std::to_string(layout_.n_q()));
    }
    if (x_0_.size() != space_.n_x()) {
      throw SceneError("x_0 has " + std::to_string(x_0_.size()) + " values: must have " +
                       std::to_string(space_.n_x()));
    }
    if (!A_.allFinite() || !x_0_.allFinite()) throw SceneError("A and x_0: must be finite");
    for (const DofSpec& dof : dofs_) {
      if (!(std::isfinite(dof.lower) && std::isfinite(dof.upper) && dof.lower < dof.upper)) {
        throw SceneError("dof " + dof.name + ": lower must be < upper, both finite");
      }
    }
    mean_J_a_ = actuated_norm(A_, layout_);
  }

  MapStatus evaluate(const VecQ& q, VecX& x_probe, MatXQ& J) const noexcept override {
    if (q.size() != layout_.n_q() || !q.allFinite()) return MapStatus::kCannotClose;
    x_probe = x_0_;
    x_probe.noalias() += A_.lazyProduct(q);
    J = A_;
    return MapStatus::kOk;
  }

  Drawing drawing() const override { return linear_drawing(dofs_, space_.coordinates(), A_, x_0_); }

 private:
  MatXQ A_;
  VecX x_0_;
};

}  // namespace

std::unique_ptr<Kinematics> make_linear(const LinearMap& map) {
  return std::make_unique<Linear>(map);
}

}  // namespace haptic::core
