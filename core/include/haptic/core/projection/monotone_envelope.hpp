#pragma once
/// The monotone envelope (METHOD 2.4): of all subspace proxies met on the way from the haptic probe to
/// the proxy, x_probe + s dx with s in (0, 1], the one that pulls hardest towards the proxy as the
/// finger feels it, S q*(s) - q_a of the sign of S J^+ dx. Continuous where the direction guard
/// switches, and equal to Eq. (6) where the way is monotone. For one actuated DoF.

#include "haptic/core/linear/least_squares.hpp"
#include "haptic/core/model/kinematics.hpp"
#include "haptic/core/projection/projection.hpp"
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

  /// `kinematics` must outlive this, with one actuated DoF.
  explicit MonotoneEnvelope(const Kinematics& kinematics);

  /// `out`: the renderer's answer for the proxy x_probe (+) dx. The anchors of Eq. (1), (4) and (8)
  /// grow in proportion to s: theirs is the proxy's, or none. Eq. (6) is followed by Gauss-Newton
  /// from point to point, as far as f and the box of q* reach. Never allocates.
  [[nodiscard]] EnvelopeAnswer apply(const Probe& probe, const VecX& dx, RendererKind renderer,
                                     Projection& out) noexcept;

 private:
  /// Gauss-Newton from q_ to the point x_at_. False where it is not reached inside the box.
  [[nodiscard]] bool reach(const VecX& x_at) noexcept;

  const Kinematics* kinematics_;
  int actuated_;
  LeastSquares solver_;
  VecA one_;
  VecQ q_{}, best_{};
  VecX x_at_{}, x_{}, r_{};
  MatXQ J_{};
};

}  // namespace haptic::core
