#pragma once
/// Values of the crossing as messages of haptic.v1, and back. No transport.

#include <string>

#include "haptic/v1/haptic_service.pb.h"
#include "haptic/v1/session.pb.h"
#include "server/crossing/outcome.hpp"
#include "server/crossing/ports.hpp"
#include "server/crossing/server_facts.hpp"

namespace haptic::server {

[[nodiscard]] v1::Event to_proto(const DeviceEvent& event);
/// With what of `asked` was held at the scene's.
[[nodiscard]] v1::UpdateSettingsResponse to_proto(const SettingsRequest& asked,
                                                  const Settings& applied);
[[nodiscard]] v1::GetServerInfoResponse to_proto(const ServerFacts& facts);
/// `period`: of the loop.
[[nodiscard]] v1::Device describe(const DeviceFacts& facts, const DeviceStatus& status,
                                  core::Duration period);
void set(google::protobuf::Duration& message, core::Duration duration);

/// Empty for a text that is too long to be one.
[[nodiscard]] SessionId session_id(const std::string& text);
/// Overwrites what the message says: all but device, epoch, arrival, left and carrier.
void from_proto(const v1::ProxySample& message, ProxySample& sample);
[[nodiscard]] PoseSample from_proto(const v1::TrackerSample& message);
[[nodiscard]] LeaseRequest from_proto(const v1::OpenSession& open, const std::string& client_name);
/// Refuses a renderer that the protocol does not know.
[[nodiscard]] Outcome<SettingsRequest> from_proto(const v1::UpdateSettingsRequest& message);

}  // namespace haptic::server
