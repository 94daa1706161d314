/// Opening and closing a session, and what the user may ask at any time.

#include "remote_session.hpp"

#include <pthread.h>

#include "convert.hpp"
#include "haptic/wire/utf8.hpp"

namespace haptic::client {

namespace {

/// How long close() waits for the server to hear the farewell: a lease that waits for a client
/// which will not come back keeps the device's damping on.
constexpr std::chrono::milliseconds kFarewell{500};

}  // namespace

RemoteSession::RemoteSession(std::shared_ptr<grpc::Channel> channel, const std::string& address,
                             SessionOptions options)
    : options_(std::move(options)),
      address_(address),
      channel_(std::move(channel)),
      stub_(v1::HapticService::NewStub(channel_)),
      reconnection_(reconnects()),
      force_(options_.re_engage, options_.re_engage && resumable()) {}

RemoteSession::~RemoteSession() {
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

void RemoteSession::open() {
  if (!wire::is_utf8(options_.client_name) || !wire::is_utf8(options_.device)) {
    throw ClientError(ErrorReason::kInvalidArgument, "client_name, device: must be UTF-8");
  }
  if (options_.observer && options_.tracker) {
    throw ClientError(ErrorReason::kInvalidArgument,
                      "observer, tracker: must not be true both, a session has one role");
  }
  connect(false);
  fetch_device();
  estimator_ = ContactEstimator(device_.coordinates, options_.blocks);
  worker_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "haptic-client");
    work();
  });
}

void RemoteSession::fetch_device() {
  const auto answer = call(*stub_, &Stub::ListDevices, {}, options_.timeout);
  for (const v1::Device& device : answer.devices()) {
    if (device.name() == opened_.device()) device_ = read_as<DeviceInfo>(device);
  }
}

v1::OpenSession RemoteSession::opening() const {
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
  if (resumable() && !force_.owes_release()) open.set_resume(opened_.session_id());
  open.set_events_after_ns(newest_event_ns_);
  open.set_udp_wanted(options_.carriers != Carriers::kGrpcOnly && !options_.tracker);
  if (options_.fresh_end) write(*options_.fresh_end, *open.mutable_fresh_end());
  if (options_.hold_end) write(*options_.hold_end, *open.mutable_hold_end());
  if (options_.fade_end) write(*options_.fade_end, *open.mutable_fade_end());
  return open;
}

void RemoteSession::connect(bool again) {
  auto stream = std::make_shared<Stream>(*stub_, *this);
  v1::OpenSession open;
  {
    const std::lock_guard lock(mutex_);
    if (!reconnection_.begin()) {
      throw ClientError(ErrorReason::kClosed, "the session was closed");
    }
    stream_ = stream;
    open = opening();
  }
  stream->start(open, again);
  Lock lock(mutex_);
  const bool answered = changed_.wait_for(lock, options_.timeout, [this] {
    return reconnection_.state() != Reconnection::State::kOpening;
  });
  if (!answered) {
    const std::string waited = std::to_string(options_.timeout.count());
    reconnection_.ended({ErrorReason::kTimeout, "no answer to OpenSession in " + waited + " ms"});
  }
  // close() says farewell on this stream, and ends it.
  if (reconnection_.closed()) throw ClientError(ErrorReason::kClosed, "the session was closed");
  if (reconnection_.open()) {
    try {
      start_udp(lock);
      return;
    } catch (const ClientError& error) {
      if (!lock.owns_lock()) lock.lock();
      reconnection_.ended(error);
    }
  }
  const ClientError why = reconnection_.why();
  stream_.reset();
  lock.unlock();
  stream->end();
  throw why;
}

DeviceState RemoteSession::state() const {
  const std::lock_guard lock(mutex_);
  return states_.give();
}

DeviceState RemoteSession::wait_for_state(std::optional<std::chrono::milliseconds> timeout) {
  if (in_callback_of_grpc()) {
    throw ClientError(ErrorReason::kInvalidArgument,
                      "wait_for_state() in on_state: the next state comes after on_state returns");
  }
  const std::chrono::milliseconds patience = timeout.value_or(options_.timeout);
  Lock lock(mutex_);
  const bool answered = changed_.wait_for(
      lock, patience, [this] { return states_.to_return() || reconnection_.over(); });
  if (states_.to_return() && !reconnection_.closed()) return states_.give_to_waiting();
  if (reconnection_.closed()) throw ClientError(ErrorReason::kClosed, "the session was closed");
  if (answered) {
    const ClientError& why = reconnection_.why();
    throw ClientError(ErrorReason::kClosed, std::string("the session ended: ") + why.what(),
                      why.server_reason());
  }
  throw ClientError(ErrorReason::kTimeout,
                    "no state in " + std::to_string(patience.count()) + " ms");
}

std::string RemoteSession::session_id() const {
  const std::lock_guard lock(mutex_);
  if (!reconnection_.open()) throw ClientError(ErrorReason::kClosed, "the session is not open");
  return opened_.session_id();
}

bool RemoteSession::connected() const {
  const std::lock_guard lock(mutex_);
  return reconnection_.open();
}

std::uint32_t RemoteSession::lease_epoch() const {
  const std::lock_guard lock(mutex_);
  return opened_.lease_epoch();
}

std::chrono::nanoseconds RemoteSession::round_trip() const {
  const std::lock_guard lock(mutex_);
  return round_trip_.value();
}

PublishStatistics RemoteSession::statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

AppliedSettings RemoteSession::update(const Settings& settings) {
  v1::UpdateSettingsRequest request;
  write(settings, request);
  request.set_session_id(session_id());
  return read_as<AppliedSettings>(call(*stub_, &Stub::UpdateSettings, request, options_.timeout));
}

void RemoteSession::close() {
  std::shared_ptr<Stream> stream;
  {
    Lock lock(mutex_);
    reconnection_.close();
    stream = stream_;
    changed_.notify_all();
    work_.notify_all();
    // A callback cannot wait for its own end, nor for another's that may be waiting for this one.
    if (!in_callback()) {
      changed_.wait(lock, [&] { return !on_state_.busy && !on_event_or_end_.busy; });
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
