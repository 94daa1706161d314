#include "session_impl.hpp"

#include <pthread.h>

#include <algorithm>
#include <atomic>

#include "convert.hpp"
#include "error_mapping.hpp"

namespace haptic::client {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kEngageRetry{50};
constexpr milliseconds kEngageAnswer{1000};
constexpr milliseconds kFirstBackoff{100}, kLongestBackoff{2000};

/// Refusals that time and more samples can cure.
bool worth_retrying(const std::string& reason) {
  constexpr const char* kCurable[] = {"NOT_ARMED",    "STREAM_TOO_YOUNG", "TOO_FEW_SAMPLES",
                                      "STREAM_STALE", "DEVICE_STALE",     "OUTSIDE_WINDOW",
                                      "NO_ANSWER"};
  return std::any_of(std::begin(kCurable), std::end(kCurable),
                     [&](const char* curable) { return reason == curable; });
}

/// A user's callback: whatever it throws ends there.
template <typename Callback, typename... Arguments>
void call(const Callback& callback, const Arguments&... arguments) noexcept {
  if (!callback) return;
  try {
    callback(arguments...);
  } catch (...) {  // NOLINT(bugprone-empty-catch): the contract: no exception crosses a callback
  }
}

bool has_force(State state) {
  return state == State::kEngaging || state == State::kEngaged;
}

}  // namespace

/// One Engage in flight; owns what gRPC writes to, so that it may outlive a session that gave up.
struct Session::Impl::EngageCall {
  grpc::ClientContext context;
  v1::EngageRequest request;
  v1::EngageResponse response;
};

Session::Impl::Impl(std::shared_ptr<grpc::Channel> channel, SessionOptions options)
    : options_(std::move(options)),
      channel_(std::move(channel)),
      stub_(v1::HapticService::NewStub(channel_)) {}

Session::Impl::~Impl() {
  close();
  if (worker_.joinable()) worker_.join();
  std::shared_ptr<Stream> stream;
  {
    std::unique_lock lock(mutex_);
    if (engage_call_) engage_call_->context.TryCancel();
    changed_.wait(lock, [this] { return engage_call_ == nullptr; });
    stream = std::move(stream_);
  }
  stream.reset();  // cancels and waits
}

void Session::Impl::open() {
  connect();
  fetch_device();
  worker_ = std::thread([this] {
    pthread_setname_np(pthread_self(), "haptic-client");
    work();
  });
}

void Session::Impl::fetch_device() {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + options_.timeout);
  v1::ListDevicesResponse response;
  check(stub_->ListDevices(&context, {}, &response));
  for (const v1::Device& device : response.devices()) {
    if (device.name() == opened_.device()) device_ = to_info(device);
  }
}

void Session::Impl::connect() {
  v1::OpenSession open;
  open.set_device(options_.device);
  open.set_role(options_.observer ? v1::ROLE_OBSERVER : v1::ROLE_CONTROLLER);
  open.set_client_name(options_.client_name);
  open.set_nominal_rate_hz(options_.nominal_rate_hz);
  open.set_state_rate_hz(options_.state_rate_hz);
  if (options_.fresh_end) set_duration(*options_.fresh_end, *open.mutable_fresh_end());
  if (options_.hold_end) set_duration(*options_.hold_end, *open.mutable_hold_end());
  if (options_.fade_end) set_duration(*options_.fade_end, *open.mutable_fade_end());

  auto stream = std::make_shared<Stream>(*stub_, *this);
  {
    const std::lock_guard lock(mutex_);
    if (closing_) throw ClientError(ErrorReason::kClosed, "the session was closed");
    phase_ = Phase::kOpening;
    stream_ = stream;
  }
  stream->start(open);
  std::unique_lock lock(mutex_);
  const bool answered =
      changed_.wait_for(lock, options_.timeout, [this] { return phase_ != Phase::kOpening; });
  if (answered && phase_ == Phase::kOpen) return;
  const grpc::Status status =
      answered ? end_
               : grpc::Status(grpc::StatusCode::DEADLINE_EXCEEDED,
                              "no answer to OpenSession in " +
                                  std::to_string(options_.timeout.count()) + " ms");
  phase_ = Phase::kDone;
  stream_.reset();
  lock.unlock();
  stream.reset();  // cancels and waits
  throw to_error(status);
}

void Session::Impl::on_message(const v1::SessionResponse& message) {
  const std::lock_guard lock(mutex_);
  switch (message.message_case()) {
    case v1::SessionResponse::kOpened:
      opened_ = message.opened();
      // A server that was started anew counts its ticks and our samples from the beginning.
      newest_ = {};
      waited_seq_ = 0;
      state_pending_ = false;
      earlier_ = statistics_;
      phase_ = Phase::kOpen;
      break;
    case v1::SessionResponse::kState:
      newest_ = to_state(message.state());
      state_pending_ = true;
      break;
    case v1::SessionResponse::kEvent:
      events_.push_back(to_event(message.event()));
      break;
    case v1::SessionResponse::kAck: {
      const v1::SampleAck& ack = message.ack();
      statistics_.accepted = earlier_.accepted + ack.accepted();
      statistics_.rejected_old = earlier_.rejected_old + ack.rejected_old();
      statistics_.rejected_invalid = earlier_.rejected_invalid + ack.rejected_invalid();
      statistics_.backlog = earlier_.backlog + ack.conflated_backlog();
      statistics_.last_rejection = ack.last_rejection();
      break;
    }
    case v1::SessionResponse::MESSAGE_NOT_SET:
      return;  // of a newer protocol
  }
  changed_.notify_all();
}

void Session::Impl::on_sent(std::uint64_t samples_replaced) {
  const std::lock_guard lock(mutex_);
  ++statistics_.sent;
  statistics_.conflated += samples_replaced;
}

void Session::Impl::on_done(const grpc::Status& status) {
  const std::lock_guard lock(mutex_);
  end_ = status;
  end_pending_ = phase_ == Phase::kOpen;  // while opening, connect() deals with it
  phase_ = Phase::kDone;
  changed_.notify_all();
}

void Session::Impl::publish(Proxy proxy) noexcept {
  try {
    const std::lock_guard in_order(publish_mutex_);
    v1::ProxySample sample;
    std::shared_ptr<Stream> stream;
    const auto now = Clock::now();
    sample.set_source_time_ns(now.time_since_epoch().count());
    sample.set_valid_for_us(static_cast<std::uint32_t>(
        std::clamp<std::int64_t>(proxy.valid_for.count(), 0, 0xffffffffLL)));
    sample.mutable_position()->Add(proxy.position.begin(), proxy.position.end());
    sample.set_mode(proxy.mode == Mode::kHeld ? v1::PROXY_MODE_HELD : v1::PROXY_MODE_FREE);
    {
      const std::lock_guard lock(mutex_);
      ++statistics_.published;
      sample.set_seq(++seq_);
      if (proxy.mode != last_mode_) ++mode_epoch_;
      last_mode_ = proxy.mode;
      sample.set_mode_epoch(mode_epoch_);
      const std::uint64_t used = proxy.device_seq_used != 0 ? proxy.device_seq_used : newest_.seq;
      sample.set_device_seq_used(used);
      if (used == newest_.seq && used != 0) {
        const auto held =
            std::chrono::duration_cast<std::chrono::microseconds>(now - newest_.received);
        sample.set_hold_us(
            static_cast<std::uint32_t>(std::clamp<std::int64_t>(held.count(), 0, 0xffffffffLL)));
      }
      if (phase_ == Phase::kOpen) stream = stream_;
    }
    if (stream) stream->send(sample);
  } catch (...) {  // NOLINT(bugprone-empty-catch): out of memory loses this sample, not the caller
  }
}

DeviceState Session::Impl::state() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

DeviceState Session::Impl::wait_for_state() {
  std::unique_lock lock(mutex_);
  const bool any = changed_.wait_for(lock, options_.timeout, [this] {
    return newest_.seq > waited_seq_ || closing_ ||
           (phase_ == Phase::kDone && options_.reconnect == Reconnect::kNever);
  });
  if (newest_.seq > waited_seq_ && !closing_) {
    waited_seq_ = newest_.seq;
    return newest_;
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

void Session::Impl::engage() {
  v1::EngageRequest request;
  request.set_session_id(session_id());
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + options_.timeout);
  v1::EngageResponse response;
  check(stub_->Engage(&context, request, &response));
  if (options_.re_engage) want_force(true);
}

void Session::Impl::want_force(bool wanted) {
  const std::lock_guard lock(mutex_);
  want_force_ = wanted;
  next_engage_ = Clock::now();
  changed_.notify_all();
}

void Session::Impl::release() {
  want_force(false);
  {
    // An Engage under way would otherwise be able to overtake the Release.
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return engage_call_ == nullptr; });  // it has a deadline
  }
  v1::ReleaseRequest request;
  request.set_session_id(session_id());
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + options_.timeout);
  v1::ReleaseResponse response;
  check(stub_->Release(&context, request, &response));
}

AppliedSettings Session::Impl::update(const Settings& settings) {
  v1::UpdateSettingsRequest request;
  request.set_session_id(session_id());
  request.mutable_stiffness()->Add(settings.stiffness.begin(), settings.stiffness.end());
  request.mutable_damping()->Add(settings.damping.begin(), settings.damping.end());
  request.mutable_force_limit()->Add(settings.force_limit.begin(), settings.force_limit.end());
  request.mutable_slew_limit()->Add(settings.slew_limit.begin(), settings.slew_limit.end());
  request.set_renderer(static_cast<v1::Renderer>(settings.renderer));
  if (settings.direction_guard) request.set_direction_guard(*settings.direction_guard);
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + options_.timeout);
  v1::UpdateSettingsResponse response;
  check(stub_->UpdateSettings(&context, request, &response));
  AppliedSettings answer;
  const auto list = [](const auto& field) {
    return std::vector<double>(field.begin(), field.end());
  };
  answer.applied.stiffness = list(response.stiffness());
  answer.applied.damping = list(response.damping());
  answer.applied.force_limit = list(response.force_limit());
  answer.applied.slew_limit = list(response.slew_limit());
  answer.applied.renderer = static_cast<Renderer>(response.renderer());
  answer.applied.direction_guard = response.direction_guard();
  for (const auto& clamp : response.clamped()) {
    answer.clamped.push_back({clamp.field(), clamp.asked(), clamp.applied(), clamp.why()});
  }
  return answer;
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
    const std::lock_guard lock(mutex_);
    closing_ = true;
    stream = stream_;
    changed_.notify_all();
  }
  if (stream) stream->cancel();
}

void Session::Impl::work() {
  std::unique_lock lock(mutex_);
  while (!closing_) {
    deliver(lock);
    if (closing_) break;
    if (end_pending_) {
      handle_end(lock);
    } else if (reconnecting_ && Clock::now() >= next_connect_) {
      reconnect(lock);
    } else if (want_force_ && phase_ == Phase::kOpen && !engage_call_ &&
               !has_force(newest_.state) && Clock::now() >= next_engage_) {
      ask_for_force(lock);
    } else if (!state_pending_ && events_.empty()) {
      changed_.wait_for(lock, milliseconds(20));
    }
  }
}

void Session::Impl::deliver(std::unique_lock<std::mutex>& lock) {
  while (!events_.empty() && !closing_) {
    const Event event = std::move(events_.front());
    events_.pop_front();
    const bool lost = event.kind == static_cast<unsigned>(v1::Event::KIND_LOST);
    const bool fault = event.kind == static_cast<unsigned>(v1::Event::KIND_FAULT);
    // Whoever clears a fault, perhaps an emergency stop, must not start a motor by that.
    if (fault || (lost && !options_.re_engage)) want_force_ = false;
    lock.unlock();
    call(options_.on_event, event);
    lock.lock();
  }
  if (!state_pending_ || closing_) return;
  state_pending_ = false;
  if (!options_.on_state) return;
  const DeviceState state = newest_;
  lock.unlock();
  call(options_.on_state, state);
  lock.lock();
}

void Session::Impl::handle_end(std::unique_lock<std::mutex>& lock) {
  end_pending_ = false;
  const ClientError error = to_error(end_);
  const bool again = options_.reconnect == Reconnect::kWithBackoff;
  if (!options_.re_engage) want_force_ = false;  // force never returns by itself
  reconnecting_ = again;
  backoff_ = kFirstBackoff;
  next_connect_ = Clock::now() + backoff_;
  lock.unlock();
  call(options_.on_disconnect, error, again);
  lock.lock();
}

void Session::Impl::reconnect(std::unique_lock<std::mutex>& lock) {
  std::shared_ptr<Stream> old = std::move(stream_);
  lock.unlock();
  old.reset();
  std::optional<ClientError> error;
  try {
    connect();
  } catch (const ClientError& failed) {
    error = failed;
  }
  lock.lock();
  if (!error) {
    reconnecting_ = false;
    next_engage_ = Clock::now();
    return;
  }
  backoff_ = std::min(backoff_ * 2, kLongestBackoff);
  next_connect_ = Clock::now() + backoff_;
  if (closing_) return;
  lock.unlock();
  call(options_.on_disconnect, *error, true);
  lock.lock();
}

void Session::Impl::ask_for_force(std::unique_lock<std::mutex>& lock) {
  auto engage = std::make_shared<EngageCall>();
  engage->request.set_session_id(opened_.session_id());
  engage->context.set_deadline(std::chrono::system_clock::now() + kEngageAnswer);
  engage_call_ = engage;
  lock.unlock();
  stub_->async()->Engage(&engage->context, &engage->request, &engage->response,
                         [this, engage](const grpc::Status& status) { force_answered(status); });
  lock.lock();
}

void Session::Impl::force_answered(const grpc::Status& status) {
  const std::lock_guard lock(mutex_);
  next_engage_ = Clock::now() + kEngageRetry;
  if (status.ok()) {
    // Asked again only where the caller wants it back after a loss; states say ENGAGING soon.
    want_force_ = want_force_ && options_.re_engage;
    next_engage_ = Clock::now() + 4 * kEngageRetry;
  } else if (status.error_code() != grpc::StatusCode::DEADLINE_EXCEEDED &&
             status.error_code() != grpc::StatusCode::UNAVAILABLE &&
             !worth_retrying(to_error(status).server_reason())) {
    want_force_ = false;
  }
  engage_call_.reset();
  changed_.notify_all();
}

}  // namespace haptic::client
