#pragma once
/// The ways to q* that are compared: ours and the peers', behind one call each.

#include <memory>
#include <string>
#include <vector>

#include "tests/report/work_precision/study.hpp"

namespace haptic::report {

class Method {
 public:
  explicit Method(std::string name) : name_(std::move(name)) {}
  virtual ~Method() = default;
  Method(const Method&) = delete;
  Method& operator=(const Method&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  /// A new run; what starts warm starts from this q*.
  virtual void begin(const core::VecQ& q_star) { static_cast<void>(q_star); }
  /// q* for this proxy, with the device at q. f and J are part of the work.
  [[nodiscard]] virtual const core::VecQ& solve(const core::VecQ& q, const core::VecX& x) = 0;

 private:
  std::string name_;
};
using Methods = std::vector<std::unique_ptr<Method>>;

/// Eq. (8) as the tick solves it (first of all: what the others are compared with); the same block by
/// block where the map has blocks; 1 to 4 steps of Gauss-Newton from q and from the last q*; core's
/// iteration to 1e-12 with Levenberg-Marquardt where a step fails; the closed form.
[[nodiscard]] Methods own_methods(const core::Kinematics& map);
/// Ceres' TinySolver from the last q*, tolerances 1e-12; none where its header was not there.
[[nodiscard]] Methods tiny_solver_methods(const core::Kinematics& map);
/// MINPACK's lmder from the last q*, tolerances 1e-12; none where cminpack was not there.
[[nodiscard]] Methods cminpack_methods(const core::Kinematics& map);

}  // namespace haptic::report
