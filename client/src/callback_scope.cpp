#include "callback_scope.hpp"

namespace haptic::client {

namespace {
// Counters: a callback may publish, and so cause another on the same thread.
thread_local int callbacks = 0;
thread_local int on_grpc = 0;
}  // namespace

bool in_callback() noexcept {
  return callbacks > 0;
}

bool in_callback_of_grpc() noexcept {
  return callbacks > 0 && on_grpc > 0;
}

CallbackScope::CallbackScope() noexcept {
  ++callbacks;
}
CallbackScope::~CallbackScope() {
  --callbacks;
}

GrpcThreadScope::GrpcThreadScope() noexcept {
  ++on_grpc;
}
GrpcThreadScope::~GrpcThreadScope() {
  --on_grpc;
}

}  // namespace haptic::client
