#pragma once
/// Maps for tests: a linear one of any matrix, and another map without its closed form.

#include <Eigen/Core>
#include <memory>
#include <string>

#include "haptic/core/model/linear.hpp"

namespace haptic::core::samples {

/// x = A q of n_a actuated and then sensed DoFs in m, within +-`box` of 0; x in `unit`.
inline LinearMap linear_parameters(const Eigen::MatrixXd& A, int n_a, double box = 1e6,
                                   Unit unit = Unit::kMetre) {
  LinearMap map;
  for (int i = 0; i < A.cols(); ++i) {
    map.dofs.push_back({"q" + std::to_string(i), Unit::kMetre, i < n_a, -box, box});
  }
  for (int i = 0; i < A.rows(); ++i) {
    map.coordinates.push_back({"x" + std::to_string(i), unit, CoordinateKind::kLinear});
  }
  map.A = A;
  return map;
}

inline std::unique_ptr<Kinematics> linear_map(const Eigen::MatrixXd& A, int n_a, double box = 1e6,
                                              Unit unit = Unit::kMetre) {
  return make_linear(linear_parameters(A, n_a, box, unit));
}

/// Another map, which must outlive this one, without its inverse, blocks and limits. Counts how
/// often it is asked.
class Wrapped : public Kinematics {
 public:
  explicit Wrapped(const Kinematics& map) : Kinematics(map.dofs(), map.space()), map_(map) {
    mean_J_a_ = map.mean_actuated_jacobian();
  }
  MapStatus evaluate(const VecQ& q, VecX& x, MatXQ& J) const noexcept override {
    ++evaluations;
    return map_.evaluate(q, x, J);
  }
  MapStatus position(const VecQ& q, VecX& x) const noexcept override {
    ++positions;
    return map_.position(q, x);
  }
  [[nodiscard]] const Kinematics& map() const { return map_; }

  mutable int evaluations{0}, positions{0};

 private:
  const Kinematics& map_;
};

}  // namespace haptic::core::samples
