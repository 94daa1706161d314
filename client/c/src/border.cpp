#include "border.hpp"

#include <unistd.h>

#include <cstdlib>
#include <utility>

namespace haptic::c {

namespace {

/// The codes count down as the reasons count up.
constexpr int code_of(client::ErrorReason reason) {
  return HAPTIC_ERROR_UNREACHABLE - static_cast<int>(reason);
}
static_assert(code_of(client::ErrorReason::kUnreachable) == HAPTIC_ERROR_UNREACHABLE &&
              code_of(client::ErrorReason::kInvalidArgument) == HAPTIC_ERROR_INVALID_ARGUMENT &&
              code_of(client::ErrorReason::kProtocol) == HAPTIC_ERROR_PROTOCOL);

}  // namespace

void refuse_in_a_child() {
  static const pid_t first = getpid();
  if (getpid() == first) return;
  throw client::ClientError(client::ErrorReason::kClosed,
                            "this process was forked from process " + std::to_string(first) +
                                ", which has the connections: start a program of its own instead");
}

Handles<haptic_connection, client::Connection>& connections() {
  static auto& handles = *new Handles<haptic_connection, client::Connection>(0);
  return handles;
}

Handles<haptic_session, Session>& sessions() {
  static auto& handles = *new Handles<haptic_session, Session>(8);
  // A program may end with a session open: its threads stop before protobuf is taken down.
  static const int at_exit = std::atexit([] {
    guarded(nullptr, [] {
      refuse_in_a_child();
      for (const auto& session : sessions().take_all()) (*session)->close();
    });
  });
  static_cast<void>(at_exit);
  return handles;
}

int report(haptic_error* error, int code, const char* message, const char* server_reason) noexcept {
  using Error = haptic_error;
  if (error == nullptr || error->size < kFirstSize<Error> || error->size > kLargestSize<Error>) {
    return code;
  }
  haptic_error value{};
  value.code = code;
  write_text(server_reason, value.server_reason);
  write_text(message, value.message);
  write(value, error);
  return code;
}

int report(haptic_error* error, const client::ClientError& why) noexcept {
  return report(error, code_of(why.reason()), why.what(), why.server_reason().c_str());
}

Session::Session(client::Connection& connection, client::SessionOptions options)
    : observer_(options.observer), tracker_(options.tracker) {
  options.on_event = [this](const client::Event& event) {
    haptic_event told{};
    told.kind = static_cast<std::int32_t>(event.kind);
    told.state = static_cast<std::int32_t>(event.state);
    told.server_time_ns = event.server_time_ns;
    keep(told, event.reason, event.message);
  };
  options.on_disconnect = [this](const client::ClientError& why, bool will_retry) {
    haptic_event told{};
    told.kind = HAPTIC_EVENT_DISCONNECTED;
    told.state = will_retry ? 1 : 0;
    keep(told, why.server_reason(), why.what());
    const std::lock_guard lock(mutex_);
    if (!will_retry) ended_ = why;
  };
  session_ = connection.open(std::move(options));
  const client::DeviceInfo& device = session_->device();
  if (device.dofs.size() > HAPTIC_MAX_DOFS || device.coordinates.size() > HAPTIC_MAX_COORDINATES) {
    throw client::ClientError(client::ErrorReason::kProtocol,
                              "the device '" + device.name + "' has " +
                                  std::to_string(device.dofs.size()) + " DoFs and " +
                                  std::to_string(device.coordinates.size()) +
                                  " coordinates: more than haptic_state has room for");
  }
}

void Session::keep(haptic_event event, const std::string& reason, const std::string& message) {
  write_text(reason, event.reason);
  write_text(message, event.message);
  const std::lock_guard lock(mutex_);
  if (events_.size() == kMostEvents) {
    events_.pop_front();
    ++lost_;
  }
  events_.push_back(event);
}

void Session::check_publisher(bool of_poses) {
  if (observer_) refuse("an observer publishes nothing: open the session without `observer`");
  if (tracker_ && !of_poses) refuse("a session with `tracker` publishes poses, not proxies");
  if (!tracker_ && of_poses) refuse("only a session with `tracker` publishes poses");
  const std::lock_guard lock(mutex_);
  if (!ended_) return;
  throw client::ClientError(client::ErrorReason::kClosed,
                            std::string("the session ended: ") + ended_->what(),
                            ended_->server_reason());
}

int Session::next_event(haptic_event& event) {
  const std::lock_guard lock(mutex_);
  if (events_.empty()) return HAPTIC_NOTHING;
  event = events_.front();
  events_.pop_front();
  event.lost = std::exchange(lost_, 0);
  return HAPTIC_OK;
}

}  // namespace haptic::c
