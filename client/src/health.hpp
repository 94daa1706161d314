#pragma once
/// The standard health service, as a client asks it (private to client/src).

#include <grpcpp/channel.h>

#include <chrono>
#include <memory>
#include <string>

namespace haptic::client {

/// Whether `service` (empty: the server as a whole) is SERVING. Throws ClientError where there is no
/// answer, or no such service.
[[nodiscard]] bool healthy(const std::shared_ptr<grpc::Channel>& channel,
                           const std::string& service, std::chrono::milliseconds timeout);

}  // namespace haptic::client
