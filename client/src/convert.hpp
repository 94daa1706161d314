#pragma once
/// The library's types from messages, and settings to a message.

#include "haptic/client/link.hpp"
#include "haptic/client/session.hpp"
#include "haptic/client/types.hpp"
#include "haptic/v1/haptic_service.pb.h"
#include "haptic/v1/session.pb.h"

namespace haptic::client {

/// `received` is now.
[[nodiscard]] DeviceState to_state(const v1::DeviceState& message);
/// Generated.
void write(const Plane& from, v1::Plane& to);
[[nodiscard]] Event to_event(const v1::Event& message);
[[nodiscard]] DeviceInfo to_info(const v1::Device& message);
[[nodiscard]] ServerInfo to_info(const v1::GetServerInfoResponse& message);
[[nodiscard]] LinkReport to_report(const v1::GetLinkStatsResponse& message);
[[nodiscard]] v1::UpdateSettingsRequest to_request(const Settings& settings);
[[nodiscard]] AppliedSettings to_settings(const v1::UpdateSettingsResponse& message);
[[nodiscard]] std::chrono::nanoseconds to_duration(const google::protobuf::Duration& message);
template <typename Number>
[[nodiscard]] std::vector<Number> to_vector(const google::protobuf::RepeatedField<Number>& field) {
  return {field.begin(), field.end()};
}

}  // namespace haptic::client
