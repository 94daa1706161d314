/// Asking for force, in the foreground and in the background, and giving it up.

#include <algorithm>
#include <utility>

#include "error_mapping.hpp"
#include "session_impl.hpp"

namespace haptic::client {

namespace {

constexpr std::chrono::milliseconds kEngageRetry{50};
constexpr std::chrono::milliseconds kForceAnswer{1000};

/// Refusals that time and more samples can cure.
bool worth_retrying(const grpc::Status& status) {
  constexpr const char* kCurable[] = {"NOT_ARMED",     "STREAM_TOO_YOUNG", "TOO_FEW_SAMPLES",
                                      "STREAM_STALE",  "DEVICE_STALE",     "OUTSIDE_WINDOW",
                                      "TRACKER_STALE", "NO_ANSWER"};
  if (status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED ||
      status.error_code() == grpc::StatusCode::UNAVAILABLE) {
    return true;
  }
  const std::string reason = to_error(status).server_reason();
  return std::any_of(std::begin(kCurable), std::end(kCurable),
                     [&](const char* curable) { return reason == curable; });
}

}  // namespace

void Session::Impl::engage() {
  v1::EngageRequest request;
  request.set_session_id(session_id());
  grpc::ClientContext context;
  set_deadline(context);
  v1::EngageResponse response;
  check(stub_->Engage(&context, request, &response));
  if (options_.re_engage) want_force(true);
}

void Session::Impl::want_force(bool wanted) {
  const std::lock_guard lock(mutex_);
  want_force_ = wanted;
  refusal_.reset();
  asked_at_ = next_engage_ = Clock::now();
  changed_.notify_all();
  work_.notify_all();
}

void Session::Impl::give_up_force(const ClientError& why) {
  if (want_force_) refusal_ = why;
  want_force_ = false;
}

void Session::Impl::release() {
  want_force(false);
  {
    // An Engage under way would otherwise be able to overtake the Release.
    Lock lock(mutex_);
    if (in_callback_of_grpc()) {
      superseded_ = engage_call_ != nullptr;  // its answer may need this very thread
    } else {
      changed_.wait(lock, [this] { return engage_call_ == nullptr; });  // it has a deadline
    }
    if (phase_ != Phase::kOpen) {  // the force fades out, unless the session were resumed with it
      release_due_ = true;
      return;
    }
  }
  v1::ReleaseRequest request;
  request.set_session_id(session_id());
  grpc::ClientContext context;
  set_deadline(context);
  v1::ReleaseResponse response;
  check(stub_->Release(&context, request, &response));
}

void Session::Impl::release_again(Lock& lock) {
  if (phase_ != Phase::kOpen) release_due_ = true;
  if (release_call_ || phase_ != Phase::kOpen) return;
  auto release = std::make_shared<ReleaseCall>();
  release->request.set_session_id(opened_.session_id());
  release->context.set_deadline(std::chrono::system_clock::now() + kForceAnswer);
  release_call_ = release;
  lock.unlock();
  stub_->async()->Release(&release->context, &release->request, &release->response,
                          [this, release](const grpc::Status&) {
                            const std::lock_guard guard(mutex_);
                            release_call_.reset();
                            changed_.notify_all();
                          });
  lock.lock();
}

void Session::Impl::ask_for_force(Lock& lock) {
  auto engage = std::make_shared<EngageCall>();
  engage->request.set_session_id(opened_.session_id());
  engage->context.set_deadline(std::chrono::system_clock::now() + kForceAnswer);
  engage_call_ = engage;
  lock.unlock();
  stub_->async()->Engage(&engage->context, &engage->request, &engage->response,
                         [this, engage](const grpc::Status& status) {
                           force_answered(engage->request.session_id(), status);
                         });
  lock.lock();
}

/// A lease that is over is no answer to whoever comes back for it: the session that is opened next asks
/// again, and a preemption is told by its event. Nor is what was said to a session before this one.
bool Session::Impl::ends_asking(const std::string& session_id, const grpc::Status& status) const {
  if (worth_retrying(status) || session_id != opened_.session_id()) return false;
  return !(comes_back_with_force() && to_error(status).server_reason() == "NOT_CONTROLLER");
}

void Session::Impl::force_answered(const std::string& session_id, const grpc::Status& status) {
  Lock lock(mutex_);
  next_engage_ = Clock::now() + kEngageRetry;
  if (std::exchange(superseded_, false)) {
    // Its force, if any, is to go; where the user asked anew since then, that is still to be done.
    // Before engage_call_ is reset, or the destructor would take this for the last answer.
    if (!want_force_) release_again(lock);
  } else if (status.ok()) {
    // Asked again only where the caller wants it back after a loss; states say ENGAGING soon.
    if (want_force_) refusal_.reset();
    want_force_ = want_force_ && options_.re_engage;
    next_engage_ = Clock::now() + 4 * kEngageRetry;
  } else if (want_force_) {
    refusal_ = to_error(status);
    if (ends_asking(session_id, status)) want_force_ = false;
  }
  engage_call_.reset();
  changed_.notify_all();
  work_.notify_all();
}

std::optional<ClientError> Session::Impl::engage_refusal() const {
  const std::lock_guard lock(mutex_);
  return refusal_;
}

}  // namespace haptic::client
