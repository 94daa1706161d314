#include "tests/report/hard_cases/linear_device.hpp"

#include <string>

#include "haptic/core/error.hpp"
#include "haptic/core/model/linear.hpp"

namespace haptic::report {

std::unique_ptr<core::Kinematics> linear_device(const core::MatXQ& A, int n_a) {
  core::LinearMap map;
  for (int i = 0; i < A.cols(); ++i) {
    map.dofs.push_back({"q" + std::to_string(i), core::Unit::kMetre, i < n_a, -1e9, 1e9});
  }
  for (int i = 0; i < A.rows(); ++i) {
    map.coordinates.push_back({"x" + std::to_string(i), core::Unit::kMetre});
  }
  map.A = A;
  map.x_0 = core::VecX::Zero(A.rows());
  return core::make_linear(map);
}

core::VecA force_of(core::RendererKind kind, const core::Kinematics& device, const core::VecQ& q,
                    const core::VecX& x, const core::VecA& Z_q, core::VecQ* dq) {
  core::VecX x_probe, dx(device.space().n_x());
  core::MatXQ J;
  if (device.evaluate(q, x_probe, J) != core::MapStatus::kOk) {
    throw core::SceneError("hard-cases: a pose has no image");
  }
  device.space().difference(x, x_probe, dx);
  core::Renderer renderer(kind, device);
  core::Projection out;
  renderer.project(core::Probe{q, x_probe, J}, x, dx, Z_q, true, out);
  const core::VecQ change = out.q_star - q;
  if (dq != nullptr) *dq = change;
  return Z_q.cwiseProduct(device.layout().select(change));
}

}  // namespace haptic::report
