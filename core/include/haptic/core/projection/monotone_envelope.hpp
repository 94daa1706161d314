#pragma once
/// The monotone envelope (core/METHOD.md#forces-at-the-finger): of all subspace proxies met on the
/// way from the haptic probe to the proxy, x_probe + s dx with s in (0, 1], the one that pulls
/// hardest towards the proxy as the finger feels it, S q*(s) - q_a of the sign of S J^+ dx.
/// Continuous where the direction guard switches, and equal to Eq. (6) where the way is monotone.
/// For one actuated DoF.

#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/projection/projection.hpp"
#include "haptic/core/projection/projection_model.hpp"
#include "haptic/core/projection/renderer_kind.hpp"

namespace haptic::core {

enum class EnvelopeAnswer : std::uint8_t {
  kProxy,     ///< s = 1: the anchor stays as it is
  kEarlier,   ///< q* is now one met before the proxy
  kWithheld,  ///< none pulls towards the proxy: q* untouched, the caller takes the force off
};

class MonotoneEnvelope {
 public:
  /// Points looked at before the proxy, s = k / (kPoints + 1).
  static constexpr int kPoints = 3;

  /// The model is copied; its kinematics, with one actuated DoF, must outlive this.
  explicit MonotoneEnvelope(const ProjectionModel& model);

  /// `out`: the renderer's answer for the proxy x_probe (+) dx. The anchors of Eq. (1), (4) and (8)
  /// grow in proportion to s: theirs is the proxy's, or none. Eq. (6) is followed from point to
  /// point, by the map's closed form or by Gauss-Newton, as far as q* is in reach. Never allocates.
  [[nodiscard]] EnvelopeAnswer apply(const Probe& probe, const VecX& dx, RendererKind renderer,
                                     Projection& out) noexcept;

 private:
  /// q_ of the point x_at_, by Gauss-Newton from the q_ before where there is no closed form. False
  /// where it is not reached inside the box.
  [[nodiscard]] bool reach(const VecX& x_at) noexcept;

  ProjectionModel model_;
  int actuated_;
  LeastSquares solver_;
  VecA one_;
  VecQ q_{}, best_{};
  VecX x_at_{}, x_{}, r_{};
  MatXQ J_{}, J_W_{};  ///< J_W_, dx_W_: weighed by W^{1/2}
  VecX dx_W_{};
};

}  // namespace haptic::core
