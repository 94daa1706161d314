#pragma once
/// One emergency stop over several devices: answered when the last of them has latched (private to
/// server/rpc).

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <memory>
#include <string>
#include <vector>

#include "server/session/device_sessions.hpp"

namespace haptic::server {

/// Posts the stop to every device before it waits for any; finishes `reactor` with an
/// EmergencyStopResponse.
void stop_all(const std::vector<DeviceSessions*>& devices, const std::string& reason,
              grpc::ServerUnaryReactor* reactor, grpc::ByteBuffer* response);

}  // namespace haptic::server
