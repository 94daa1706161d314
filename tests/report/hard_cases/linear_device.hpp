#pragma once
/// A device whose map is x = A q, and what a renderer commands on it.

#include <memory>

#include "haptic/core/projection/renderer.hpp"

namespace haptic::report {

/// The first n_a columns of A are actuated; every range is far away.
[[nodiscard]] std::unique_ptr<core::Kinematics> linear_device(const core::MatXQ& A, int n_a);

/// tau_a = Z_q S (q* - q), without limits. `dq`, where given, receives q* - q.
[[nodiscard]] core::VecA force_of(core::RendererKind kind, const core::Kinematics& device,
                                  const core::VecQ& q, const core::VecX& x, const core::VecA& Z_q,
                                  core::VecQ* dq = nullptr);

}  // namespace haptic::report
