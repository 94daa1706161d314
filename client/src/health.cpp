#include "health.hpp"

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/impl/codegen/proto_utils.h>

#include <future>

#include "error_mapping.hpp"
#include "grpc/health/v1/health.pb.h"

namespace haptic::client {

bool healthy(const std::shared_ptr<grpc::Channel>& channel, const std::string& service,
             std::chrono::milliseconds timeout) {
  using Request = grpc::health::v1::HealthCheckRequest;
  using Response = grpc::health::v1::HealthCheckResponse;
  grpc::TemplatedGenericStub<Request, Response> stub(channel);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + timeout);
  Request request;
  request.set_service(service);
  Response response;
  std::promise<grpc::Status> answered;
  stub.UnaryCall(&context, "/grpc.health.v1.Health/Check", {}, &request, &response,
                 [&](grpc::Status status) { answered.set_value(std::move(status)); });
  check(answered.get_future().get());
  return response.status() == Response::SERVING;
}

}  // namespace haptic::client
