#include "server/rpc/library_log.hpp"

#include <google/protobuf/stubs/logging.h>
#include <grpc/support/log.h>
#include <spdlog/spdlog.h>

namespace haptic::server {
namespace {

/// Debug only: the server reports in its own words why a call or a start failed.
void from_grpc(gpr_log_func_args* word) {
  spdlog::debug("gRPC: {}", word->message);
}

/// Debug only: the sender of a wrong message gets an answer, every time.
void from_protobuf(google::protobuf::LogLevel level, const char* /*file*/, int /*line*/,
                   const std::string& message) {
  const bool fatal = level == google::protobuf::LOGLEVEL_FATAL;
  spdlog::log(fatal ? spdlog::level::err : spdlog::level::debug, "protobuf: {}", message);
}

}  // namespace

void take_library_logs() {
  gpr_set_log_function(from_grpc);
  google::protobuf::SetLogHandler(from_protobuf);
}

}  // namespace haptic::server
