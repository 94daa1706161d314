#include "remote_watch.hpp"

#include <condition_variable>
#include <mutex>
#include <utility>

#include "call.hpp"
#include "callback.hpp"
#include "convert.hpp"

namespace haptic::client {

namespace {

/// Callbacks run on gRPC's thread of this stream, one at a time; the next message is read when a
/// callback returned, so that a slow one conflates at the server.
class RemoteWatch final : public Watch, public grpc::ClientReadReactor<v1::WatchResponse> {
 public:
  RemoteWatch(std::shared_ptr<grpc::Channel> channel, const std::string& device, double rate_hz,
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

  ~RemoteWatch() override {
    context_.TryCancel();
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [this] { return error_.has_value(); });
  }

  [[nodiscard]] bool running() const override { return !error(); }
  [[nodiscard]] std::optional<ClientError> error() const override {
    const std::lock_guard lock(mutex_);
    return error_;
  }
  [[nodiscard]] std::uint64_t conflated() const override {
    const std::lock_guard lock(mutex_);
    return conflated_;
  }

 private:
  void OnReadDone(bool ok) override {
    if (!ok) return;
    {
      const std::lock_guard lock(mutex_);
      conflated_ = response_.conflated();
    }
    if (response_.has_state() && on_state_) {
      call_back(CallbackThread::kGrpc, on_state_, to_state(response_.state()));
    }
    if (response_.has_event() && on_event_) {
      call_back(CallbackThread::kGrpc, on_event_, read_as<Event>(response_.event()));
    }
    StartRead(&response_);
  }

  void OnDone(const grpc::Status& status) override {
    const std::lock_guard lock(mutex_);
    error_ = to_error(status);
    ended_.notify_all();
  }

  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<Stub> stub_;
  std::function<void(const DeviceState&)> on_state_;
  std::function<void(const Event&)> on_event_;
  grpc::ClientContext context_;
  v1::WatchRequest request_;
  v1::WatchResponse response_;
  mutable std::mutex mutex_;
  std::condition_variable ended_;
  std::optional<ClientError> error_{};  ///< once the stream ended
  std::uint64_t conflated_{0};
};

}  // namespace

std::unique_ptr<Watch> watch_device(std::shared_ptr<grpc::Channel> channel,
                                    const std::string& device, double rate_hz,
                                    std::function<void(const DeviceState&)> on_state,
                                    std::function<void(const Event&)> on_event) {
  return std::make_unique<RemoteWatch>(std::move(channel), device, rate_hz, std::move(on_state),
                                       std::move(on_event));
}

}  // namespace haptic::client
