#pragma once
/// The monotone envelope, Eq. (16) (core/METHOD.md#forces-at-the-finger). The subspace proxies on
/// the way from the probe to the proxy are q*(s) for x_probe + s dx, s in (0, 1]; this uses the one
/// that pulls hardest towards the proxy as the finger feels it, that is, with the largest q*_a(s) -
/// q_a of the sign of S J^+ dx. It is continuous where the direction guard switches, and equal to
/// Eq. (6) if the way is monotone.
/// For one actuated DoF.

#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/rendering/projection.hpp"
#include "haptic/core/rendering/projection_model.hpp"
#include "haptic/core/rendering/renderer_kind.hpp"

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
  /// q_ of the point x_at, in closed form or else by Gauss-Newton from the q_ before. False if x_at
  /// cannot be reached inside the box.
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
