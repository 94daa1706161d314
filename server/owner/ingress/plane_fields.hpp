#pragma once
/// The numbers of a plane, by the options that their fields have in session.proto.

#include <optional>

#include "server/crossing/crossing.hpp"

namespace haptic::server {

/// Generated. Refuses a number that is not allowed; `p`: of the plane in its sample.
[[nodiscard]] std::optional<Verdict> check_fields(const PlaneSample& plane, std::size_t p);

/// Generated. Writes core::PlaneSet::lists().
void write_fields(const ProxySample& sample, core::PlaneSet& to);

}  // namespace haptic::server
