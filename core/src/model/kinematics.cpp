#include "haptic/core/model/kinematics.hpp"

#include <cmath>

#include "haptic/core/error.hpp"
#include "haptic/core/model/drawing.hpp"

namespace haptic::core {

namespace {

constexpr int kSamples = 256;  // the mean of a smooth map settles to a per cent well before
constexpr int kPrimes[kMaxQ] = {2,  3,  5,  7,  11, 13, 17, 19, 23, 29, 31, 37,
                                41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89};

double radical_inverse(int i, int base) noexcept {
  double value = 0.0, digit = 1.0;
  for (; i > 0; i /= base) {
    digit /= base;
    value += digit * (i % base);
  }
  return value;
}

}  // namespace

MapStatus Kinematics::position(const VecQ& q, VecX& x_probe) const noexcept {
  MatXQ J;
  return evaluate(q, x_probe, J);
}

Drawing Kinematics::drawing() const {
  return {};
}

std::vector<MapBlock> blocks_or_whole(const Kinematics& kinematics) {
  const std::span<const MapBlock> blocks = kinematics.blocks();
  if (blocks.empty()) return {{&kinematics, 0, 0, 0}};
  return {blocks.begin(), blocks.end()};
}

DofLayout layout_of(const std::vector<DofSpec>& dofs) {
  if (dofs.size() > static_cast<std::size_t>(kMaxQ)) {
    throw SceneError("device with " + std::to_string(dofs.size()) + " DoFs: must have at most " +
                     std::to_string(kMaxQ));
  }
  bool actuated[kMaxQ]{};
  for (std::size_t i = 0; i < dofs.size(); ++i) actuated[i] = dofs[i].actuated;
  return DofLayout(std::span<const bool>(actuated, dofs.size()));
}

VecQ workspace_sample(const Kinematics& kinematics, int i) {
  const auto& dofs = kinematics.dofs();
  VecQ q(kinematics.layout().n_q());
  for (int k = 0; k < q.size(); ++k) {
    const DofSpec& dof = dofs[static_cast<std::size_t>(k)];
    q[k] = dof.lower + (dof.upper - dof.lower) * radical_inverse(i + 1, kPrimes[k]);
  }
  return q;
}

double actuated_norm(const MatXQ& J, const DofLayout& layout) noexcept {
  double sum = 0.0;
  for (int i = 0; i < layout.n_a(); ++i) sum += J.col(layout.actuated(i)).squaredNorm();
  return std::sqrt(sum);
}

double mean_actuated_jacobian(const Kinematics& kinematics) {
  VecX x;
  MatXQ J;
  double sum = 0.0;
  int counted = 0;
  for (int s = 0; s < kSamples; ++s) {
    if (kinematics.evaluate(workspace_sample(kinematics, s), x, J) != MapStatus::kOk) continue;
    sum += actuated_norm(J, kinematics.layout());
    ++counted;
  }
  return counted > 0 ? sum / counted : 0.0;
}

}  // namespace haptic::core
