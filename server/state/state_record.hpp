#pragma once
/// The flat copy of a tick's record that crosses to the front.

#include "haptic/core/tick/tick_record.hpp"
#include "server/crossing/state_record.hpp"

namespace haptic::server {

/// `carrier`: of the proxy in use; `lease_epoch`: of its lease as clients know it. The loop knows
/// neither.
[[nodiscard]] StateRecord state_record(const core::TickRecord& record,
                                       Carrier carrier = Carrier::kNone,
                                       std::uint32_t lease_epoch = 0);

}  // namespace haptic::server
