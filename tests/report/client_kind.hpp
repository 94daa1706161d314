#pragma once
/// How a simulation's proxy lives between two samples: what closed-loop and rate compare.

#include <array>

#include "tests/report/values.hpp"
#include "tests/support/loop/remote_client.hpp"

namespace haptic::report {

enum class ClientKind {
  kHeldForce,      ///< not offered: the deviation stays, and with it the force
  kHeld,           ///< x stays
  kExtrapolated,   ///< not offered: x goes on at the rate of the last two samples
  kPlanes,         ///< every stop as a plane in every sample
  kDerivedPlanes,  ///< a plane only while the simulation sees contact (client library)
  kContacts,       ///< contacts in every sample, with their curvature and the tick they are of
};

inline constexpr std::array<ClientKind, 5> kClientKinds{
    ClientKind::kHeldForce, ClientKind::kHeld, ClientKind::kExtrapolated, ClientKind::kPlanes,
    ClientKind::kDerivedPlanes};

/// Those that hapticd and its client library offer. (Free mode out of contact, held in it, is felt
/// as a held proxy, which goes on with the probe where it was free.)
inline constexpr std::array<ClientKind, 4> kOfferedClients{
    ClientKind::kHeld, ClientKind::kPlanes, ClientKind::kDerivedPlanes, ClientKind::kContacts};

[[nodiscard]] inline std::string_view name(ClientKind kind) noexcept {
  return name_in({"held_force", "held", "extrapolated", "planes", "derived_planes", "contacts"},
                 kind);
}

struct Network {
  double rate_hz{60.0};
  double delay_s{0.0};
};

/// core/METHOD.md#local-models: jitter 30 % of the period; none at 1 kHz, which is every tick.
/// `stop`: n_x.
[[nodiscard]] test::ClientSettings client_of(ClientKind kind, const Network& network,
                                             const core::VecX& stop);

}  // namespace haptic::report
