#pragma once
/// core and server values <-> messages of haptic.v1 (private to server/rpc). No gRPC.

#include <string>

#include "haptic/v1/haptic_service.pb.h"
#include "haptic/v1/session.pb.h"
#include "server/crossing/server_facts.hpp"
#include "server/ingress/ingress.hpp"
#include "server/session/device_event.hpp"
#include "server/session/device_sessions.hpp"
#include "server/session/settings_policy.hpp"
#include "server/udp/udp_port.hpp"

namespace haptic::server {

[[nodiscard]] v1::Event to_proto(const DeviceEvent& event);
[[nodiscard]] v1::UpdateSettingsResponse to_proto(const SettingsAnswer& answer);
[[nodiscard]] v1::GetServerInfoResponse to_proto(const ServerFacts& facts);
[[nodiscard]] v1::Device describe(const DeviceSessions& device, core::Duration period);
void set(google::protobuf::Duration& message, core::Duration duration);

/// Where the path ends and its keys; `port` is bound.
void to_proto(const wire::PathKeys& keys, const UdpPort& port, v1::UdpPath& message);

/// Points into `sample`, which must outlive the candidate.
[[nodiscard]] PoseCandidate from_proto(const v1::TrackerSample& sample);
[[nodiscard]] ProxyCandidate from_proto(const v1::ProxySample& sample, std::uint32_t epoch,
                                        Carrier carrier = Carrier::kGrpc);
[[nodiscard]] LeaseRequest from_proto(const v1::OpenSession& open, std::string session_id,
                                      std::string client_name);
/// Refuses a renderer that the protocol does not know.
[[nodiscard]] Outcome<SettingsRequest> from_proto(const v1::UpdateSettingsRequest& message);

}  // namespace haptic::server
