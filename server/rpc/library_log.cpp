#include "server/rpc/library_log.hpp"

#include <google/protobuf/stubs/logging.h>
#include <grpc/support/log.h>
#include <spdlog/spdlog.h>

namespace haptic::server {
namespace {

/// What a call or a start fails of is told where it fails, in our words.
void from_grpc(gpr_log_func_args* word) {
  spdlog::debug("gRPC: {}", word->message);
}

/// What is wrong with a message is answered to whoever sent it, as often as it is sent.
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
