#include "callback_scope.hpp"

#include <algorithm>

namespace haptic::client {

namespace {
constexpr int kNone = 0, kOwnThread = 1, kGrpcThread = 2;
thread_local int running = kNone;
}  // namespace

bool in_callback() noexcept {
  return running != kNone;
}

bool in_callback_of_grpc() noexcept {
  return running == kGrpcThread;
}

CallbackScope::CallbackScope(bool on_grpc_thread) noexcept : before_(running) {
  running = std::max(before_, on_grpc_thread ? kGrpcThread : kOwnThread);
}

CallbackScope::~CallbackScope() {
  running = before_;
}

}  // namespace haptic::client
