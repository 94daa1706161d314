#pragma once
/// Why a call failed, for programs: canonical code, message, ErrorInfo {reason, domain "hapticd"},
/// and a BadRequest if a field is off.

#include "google/rpc/status.pb.h"
#include "server/crossing/outcome.hpp"

namespace haptic::server {

[[nodiscard]] google::rpc::Status rich_status(const Refusal& refusal);

}  // namespace haptic::server
