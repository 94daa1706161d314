#pragma once
/// Two diagnostics that a state contains if the device's scene asks for them: the passivity
/// certificate of the linearised method, and a metric for a projection of the client's own.

#include <cstdint>
#include <vector>

namespace haptic::client {

/// How far the force of the linearised subspace method, Eq. (8), is from pushing along with a
/// motion of the device, with the proxy held where it is: core/METHOD.md#exact-derivatives.
struct CertificateState {
  enum class Status : std::uint8_t {
    kUnknown = 0,
    kComputed = 1,
    kIdle = 2,           ///< no proxy that is displaced: nothing pulls
    kOtherRenderer = 3,  ///< another renderer than Renderer::kSubspaceLinear is in use
    kMapFailed = 4,      ///< the device's map has no value or no second derivative here
    kNotFullRank = 5,    ///< of the Jacobian of `block`
    kNoStiffness = 6,    ///< an actuator of `block` has stiffness 0
  };
  Status status{Status::kUnknown};
  double margin{0.0};  ///< while kComputed; 1 with the proxy at the probe, 0 or less: not passive
  unsigned block{0};   ///< independent part of the map (a finger) with the least margin
};
[[nodiscard]] const char* name(CertificateState::Status status) noexcept;  ///< "COMPUTED"

/// A metric W on the next `coordinates` virtual coordinates, for a client that projects its proxy
/// itself: stiff along what the actuators can push, soft along what is only sensed
/// (core/METHOD.md#anisotropic-coupling). In J per product of the units of two coordinates.
struct CouplingBlock {
  unsigned coordinates{0};
  /// The lower triangle of W row by row: W00, W10, W11, W20 ...; empty: the Jacobian has no full
  /// column rank here.
  std::vector<double> lower{};
};

}  // namespace haptic::client
