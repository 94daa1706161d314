#pragma once
/// The library's types from messages and to them.

#include "haptic/client/session.hpp"
#include "haptic/client/types.hpp"
#include "haptic/v1/haptic_service.pb.h"
#include "haptic/v1/session.pb.h"

namespace haptic::client {

// Generated (proto/generate). `to` holds the defaults.
void read(const v1::Event& from, Event& to);
void read(const v1::Device& from, DeviceInfo& to);
void read(const v1::GetServerInfoResponse& from, ServerInfo& to);
void read(const v1::GetLinkStatsResponse& from, LinkReport& to);
void read(const v1::UpdateSettingsRequest& from, Settings& to);
void read(const v1::UpdateSettingsResponse& from, AppliedSettings& to);
void write(const Event& from, v1::Event& to);
void write(const DeviceInfo& from, v1::Device& to);
void write(const ServerInfo& from, v1::GetServerInfoResponse& to);
void write(const LinkReport& from, v1::GetLinkStatsResponse& to);
void write(const Settings& from, v1::UpdateSettingsRequest& to);
void write(const AppliedSettings& from, v1::UpdateSettingsResponse& to);
void write(const Plane& from, v1::Plane& to);

/// A value that read() fills.
template <typename Type, typename Message>
[[nodiscard]] Type read_as(const Message& message) {
  Type value;
  read(message, value);
  return value;
}
/// `received` is now.
[[nodiscard]] DeviceState to_state(const v1::DeviceState& message);
[[nodiscard]] std::chrono::nanoseconds to_duration(const google::protobuf::Duration& message);
void write(std::chrono::nanoseconds from, google::protobuf::Duration& to);

}  // namespace haptic::client
