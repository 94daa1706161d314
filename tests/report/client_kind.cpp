#include "tests/report/client_kind.hpp"

#include "tests/support/loop/local_laws.hpp"

namespace haptic::report {

test::ClientSettings client_of(ClientKind kind, const Network& network, const core::VecX& stop) {
  constexpr double kEveryTick_hz = 1000.0;
  test::ClientSettings client;
  client.stop = stop;
  client.rate_hz = network.rate_hz;
  client.delay_s = network.delay_s;
  client.jitter = network.rate_hz < kEveryTick_hz ? 0.3 : 0.0;
  const bool planes = kind == ClientKind::kPlanes || kind == ClientKind::kDerivedPlanes ||
                      kind == ClientKind::kContacts;
  client.mode = planes ? core::ProxyMode::kPlanes : core::ProxyMode::kHeld;
  client.only_in_contact = kind == ClientKind::kDerivedPlanes;
  if (kind == ClientKind::kHeldForce) client.between = test::held_deviation();
  if (kind == ClientKind::kExtrapolated) client.between = test::extrapolated();
  return client;
}

}  // namespace haptic::report
