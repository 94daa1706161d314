#pragma once
/// HapticService on gRPC's callback API (private to server/front/grpc).

#include <grpcpp/impl/service_type.h>

#include <memory>

#include "server/front/service/service_context.hpp"

namespace haptic::server {

/// It speaks bytes: so one serialised state serves every stream, no mistake in its message keeps an
/// EmergencyStop from stopping, and unary calls have the table of the web. `context` must outlive
/// it.
[[nodiscard]] std::unique_ptr<grpc::Service> haptic_service(ServiceContext& context);

}  // namespace haptic::server
