#include "haptic/client/watch.hpp"

#include "callback_scope.hpp"
#include "convert.hpp"
#include "error_mapping.hpp"
#include "watch_impl.hpp"

namespace haptic::client {

Watch::Impl::Impl(std::shared_ptr<grpc::Channel> channel, const std::string& device, double rate_hz,
                  std::function<void(const DeviceState&)> on_state,
                  std::function<void(const Event&)> on_event)
    : channel_(std::move(channel)),
      stub_(v1::HapticService::NewStub(channel_)),
      on_state_(std::move(on_state)),
      on_event_(std::move(on_event)) {
  request_.set_device(device);
  request_.set_rate_hz(rate_hz);
  stub_->async()->Watch(&context_, &request_, this);
  StartRead(&response_);
  StartCall();
}

Watch::Impl::~Impl() {
  context_.TryCancel();
  std::unique_lock lock(mutex_);
  ended_.wait(lock, [this] { return !running_; });
}

void Watch::Impl::OnReadDone(bool ok) {
  if (!ok) return;
  {
    const std::lock_guard lock(mutex_);
    conflated_ = response_.conflated();
  }
  try {
    const CallbackScope scope(true);
    if (response_.has_state() && on_state_) on_state_(to_state(response_.state()));
    if (response_.has_event() && on_event_) on_event_(to_event(response_.event()));
  } catch (...) {  // NOLINT(bugprone-empty-catch): the contract: no exception crosses a callback
  }
  StartRead(&response_);
}

void Watch::Impl::OnDone(const grpc::Status& status) {
  const std::lock_guard lock(mutex_);
  error_ = to_error(status);
  running_ = false;
  ended_.notify_all();
}

bool Watch::Impl::running() const {
  const std::lock_guard lock(mutex_);
  return running_;
}

std::optional<ClientError> Watch::Impl::error() const {
  const std::lock_guard lock(mutex_);
  return error_;
}

std::uint64_t Watch::Impl::conflated() const {
  const std::lock_guard lock(mutex_);
  return conflated_;
}

Watch::Watch(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Watch::~Watch() = default;
bool Watch::running() const {
  return impl_->running();
}
std::optional<ClientError> Watch::error() const {
  return impl_->error();
}
std::uint64_t Watch::conflated() const {
  return impl_->conflated();
}

}  // namespace haptic::client
