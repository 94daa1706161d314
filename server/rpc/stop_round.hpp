#pragma once
/// One emergency stop of several devices: answered when the last of them has latched (private to
/// server/rpc).

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <memory>
#include <string>
#include <vector>

#include "server/front/front.hpp"

namespace haptic::server {

/// Posts the stop to every device before it waits for any; finishes `reactor` with an
/// EmergencyStopResponse.
void stop_all(Front& front, const std::vector<std::size_t>& devices, const std::string& reason,
              grpc::ServerUnaryReactor* reactor, grpc::ByteBuffer* response);

}  // namespace haptic::server
