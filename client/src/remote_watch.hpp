#pragma once

#include <grpcpp/grpcpp.h>

#include <functional>
#include <memory>
#include <string>

#include "haptic/client/state.hpp"
#include "haptic/client/types.hpp"
#include "haptic/client/watch.hpp"

namespace haptic::client {

/// Begins to watch a device; see Connection::watch().
[[nodiscard]] std::unique_ptr<Watch> watch_device(std::shared_ptr<grpc::Channel> channel,
                                                  const std::string& device, double rate_hz,
                                                  std::function<void(const DeviceState&)> on_state,
                                                  std::function<void(const Event&)> on_event);

}  // namespace haptic::client
