#include "session_impl.hpp"

#include <pthread.h>

#include "convert.hpp"
#include "error_mapping.hpp"
#include "haptic/wire/utf8.hpp"

namespace haptic::client {

namespace {

/// A lease that waits for a client which will not come back keeps damping on.
constexpr std::chrono::milliseconds kFarewell{500};

}  // namespace

Session::Impl::Impl(std::shared_ptr<grpc::Channel> channel, const std::string& address,
                    SessionOptions options)
    : options_(std::move(options)),
      udp_host_(udp_host(address)),
      channel_(std::move(channel)),
      stub_(v1::HapticService::NewStub(channel_)) {}

Session::Impl::~Impl() {
  close();
  if (worker_.joinable()) worker_.join();
  std::shared_ptr<Stream> stream;
  {
    Lock lock(mutex_);
    if (engage_call_) engage_call_->context.TryCancel();
    if (release_call_) release_call_->context.TryCancel();
    stop_udp(lock);
    changed_.wait(lock, [this] { return engage_call_ == nullptr && release_call_ == nullptr; });
    stream = std::move(stream_);
  }
  if (stream) stream->end();
}

void Session::Impl::open() {
  if (!wire::is_utf8(options_.client_name) || !wire::is_utf8(options_.device)) {
    throw ClientError(ErrorReason::kInvalidArgument, "client_name, device: must be UTF-8");
  }
  if (options_.observer && options_.tracker) {
    throw ClientError(ErrorReason::kInvalidArgument,
                      "observer, tracker: must not be true both, a session has one role");
  }
  connect();
  fetch_device();
  worker_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "haptic-client");
    work();
  });
}

void Session::Impl::set_deadline(grpc::ClientContext& context) const {
  context.set_deadline(std::chrono::system_clock::now() + options_.timeout);
}

void Session::Impl::fetch_device() {
  grpc::ClientContext context;
  set_deadline(context);
  v1::ListDevicesResponse response;
  check(stub_->ListDevices(&context, {}, &response));
  for (const v1::Device& device : response.devices()) {
    if (device.name() == opened_.device()) device_ = to_info(device);
  }
}

v1::OpenSession Session::Impl::opening() const {
  v1::OpenSession open;
  open.set_device(options_.device);
  open.set_role(options_.observer  ? v1::ROLE_OBSERVER
                : options_.tracker ? v1::ROLE_TRACKER
                                   : v1::ROLE_CONTROLLER);
  open.set_client_name(options_.client_name);
  open.set_nominal_rate_hz(options_.nominal_rate_hz);
  open.set_state_rate_hz(options_.state_rate_hz);
  open.set_priority(static_cast<v1::Priority>(options_.priority));
  open.set_resumable(resumable());
  if (resumable() && !release_due_) open.set_resume(opened_.session_id());
  open.set_udp_wanted(options_.carriers != Carriers::kGrpcOnly && !options_.tracker);
  if (options_.fresh_end) set_duration(*options_.fresh_end, *open.mutable_fresh_end());
  if (options_.hold_end) set_duration(*options_.hold_end, *open.mutable_hold_end());
  if (options_.fade_end) set_duration(*options_.fade_end, *open.mutable_fade_end());
  return open;
}

void Session::Impl::connect() {
  auto stream = std::make_shared<Stream>(*stub_, *this);
  v1::OpenSession open;
  {
    const std::lock_guard lock(mutex_);
    if (closing_) throw ClientError(ErrorReason::kClosed, "the session was closed");
    phase_ = Phase::kOpening;
    stream_ = stream;
    open = opening();
  }
  stream->start(open);
  Lock lock(mutex_);
  const bool answered =
      changed_.wait_for(lock, options_.timeout, [this] { return phase_ != Phase::kOpening; });
  if (answered && phase_ == Phase::kOpen) return start_udp(lock);
  const grpc::Status status =
      answered ? end_
               : grpc::Status(grpc::StatusCode::DEADLINE_EXCEEDED,
                              "no answer to OpenSession in " +
                                  std::to_string(options_.timeout.count()) + " ms");
  phase_ = Phase::kDone;
  stream_.reset();
  lock.unlock();
  stream->end();
  throw to_error(status);
}

DeviceState Session::Impl::hand_out() const {
  handed_seq_ = newest_.seq;
  handed_received_ = newest_.received;
  handed_x_probe_ = newest_.x_probe;
  return newest_;
}

DeviceState Session::Impl::state() const {
  const std::lock_guard lock(mutex_);
  return hand_out();
}

DeviceState Session::Impl::wait_for_state() {
  if (in_callback_of_grpc()) {
    throw ClientError(ErrorReason::kInvalidArgument,
                      "wait_for_state() in on_state: no state comes before the callback returned");
  }
  Lock lock(mutex_);
  const bool any = changed_.wait_for(lock, options_.timeout, [this] {
    return newest_.seq > waited_seq_ || closing_ ||
           (phase_ == Phase::kDone && !end_pending_ && !reconnecting_);
  });
  if (newest_.seq > waited_seq_ && !closing_) {
    waited_seq_ = newest_.seq;
    return hand_out();
  }
  if (any) throw ClientError(ErrorReason::kClosed, "the session ended");
  throw ClientError(ErrorReason::kTimeout,
                    "no state in " + std::to_string(options_.timeout.count()) + " ms");
}

std::string Session::Impl::session_id() const {
  const std::lock_guard lock(mutex_);
  if (phase_ != Phase::kOpen) throw ClientError(ErrorReason::kClosed, "the session is not open");
  return opened_.session_id();
}

bool Session::Impl::connected() const {
  const std::lock_guard lock(mutex_);
  return phase_ == Phase::kOpen && !closing_;
}

std::uint32_t Session::Impl::lease_epoch() const {
  const std::lock_guard lock(mutex_);
  return opened_.lease_epoch();
}

PublishStatistics Session::Impl::statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

void Session::Impl::close() {
  std::shared_ptr<Stream> stream;
  {
    Lock lock(mutex_);
    closing_ = true;
    stream = stream_;
    changed_.notify_all();
    work_.notify_all();
    // A callback cannot wait for its own end, nor for another's that may be waiting for this one.
    if (!in_callback()) {
      changed_.wait(lock, [&] { return !states_.busy && !events_and_end_.busy; });
    }
  }
  if (!stream) return;
  if (resumable()) {
    stream->leave(in_callback() ? std::chrono::milliseconds(0) : kFarewell);
    if (in_callback()) return;  // the server ends it; if not, the destructor does
  }
  stream->cancel();
}

}  // namespace haptic::client
