#pragma once
/// Proxies between two samples that hapticd does not offer, to measure what they would do.

#include <memory>

#include "haptic/core/model/kinematics.hpp"
#include "tests/support/loop/remote_client.hpp"

namespace haptic::test {

/// x (-) x_probe of the newest sample stays: the force is held, not the proxy
/// (core/METHOD.md#local-models: the worst option).
[[nodiscard]] LocalLaw held_deviation();

/// x goes on at the rate between the two newest samples, for one period at most
/// (core/METHOD.md#local-models).
[[nodiscard]] LocalLaw extrapolated();

/// The form that core/METHOD.md#local-models rejects, conservative in the metric of Q:
///   q* = argmin 1/2 Z_q (q*_a - q_a)^2 + 1/2 M_n (q*_n - q_n^ref)^2   s.t. f(q*) <= stop
/// with q_n^ref held per sample and q_a live; the proxy is f(q*), so that the exact method renders
/// just tau_a = Z_q (q*_a - q_a). For a finger: n_q = n_x = 2, one of them actuated, an inverse.
struct QMetric {
  std::shared_ptr<const core::Kinematics> finger{};
  core::VecX stop{};           ///< rad, n_x; infinity: none
  double sensed_weight{30.0};  ///< c in M_n = c (0.02 m/rad)^2 Z_q
};
[[nodiscard]] LocalLaw q_metric(const QMetric& what);

}  // namespace haptic::test
