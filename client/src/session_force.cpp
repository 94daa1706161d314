/// Engage and Release: at the user's word, and in the background.

#include "remote_session.hpp"

namespace haptic::client {

void RemoteSession::engage() {
  v1::EngageRequest request;
  request.set_session_id(session_id());
  call(*stub_, &Stub::Engage, request, options_.timeout);
  if (options_.re_engage) engage_when_ready();
}

void RemoteSession::engage_when_ready() {
  const std::lock_guard lock(mutex_);
  force_.want(Clock::now());
  work_.notify_all();
}

std::optional<ClientError> RemoteSession::engage_refusal() const {
  const std::lock_guard lock(mutex_);
  return force_.refusal();
}

void RemoteSession::release() {
  {
    Lock lock(mutex_);
    // An Engage under way could overtake the Release. A callback of gRPC cannot wait for its
    // answer, which may need this very thread; it has a deadline.
    force_.release(in_callback_of_grpc());
    if (!in_callback_of_grpc()) {
      changed_.wait(lock, [this] { return engage_call_ == nullptr; });
    }
    if (!reconnection_.open()) {
      force_.owe_release(true);  // force fades out by itself, unless the session is resumed with it
      return;
    }
  }
  v1::ReleaseRequest request;
  request.set_session_id(session_id());
  call(*stub_, &Stub::Release, request, options_.timeout);
}

void RemoteSession::send_release(Lock& lock) {
  force_.owe_release(!reconnection_.open() || release_call_ != nullptr);
  if (force_.owes_release()) return;  // later, by the worker
  const auto release = release_call_ = std::make_shared<ReleaseCall>(opened_.session_id());
  lock.unlock();
  stub_->async()->Release(&release->context, &release->request, &release->response,
                          [this, release](const grpc::Status&) {
                            const std::lock_guard guard(mutex_);
                            release_call_.reset();
                            changed_.notify_all();
                            work_.notify_all();
                          });
  lock.lock();
}

RemoteSession::Clock::time_point RemoteSession::engage_due() const {
  using State = Reconnection::State;
  // Without its lease a session asks in vain; one that reconnects has another with its next sample.
  const bool lease_comes_back = options_.re_engage && resumable();
  const bool open = reconnection_.state() == State::kOpen ||
                    (reconnection_.state() == State::kLeaseLost && !lease_comes_back);
  // One call at a time: its answer ends the one that engage_call_ names.
  if (!open || engage_call_ || has_force(states_.newest().state)) return Clock::time_point::max();
  return force_.due().value_or(Clock::time_point::max());
}

void RemoteSession::send_engage(Lock& lock) {
  const auto engage = engage_call_ = std::make_shared<EngageCall>(opened_.session_id());
  force_.asked();
  lock.unlock();
  stub_->async()->Engage(&engage->context, &engage->request, &engage->response,
                         [this, engage](const grpc::Status& status) {
                           engage_answered(engage->request.session_id(), status);
                         });
  lock.lock();
}

void RemoteSession::engage_answered(const std::string& session_id, const grpc::Status& status) {
  Lock lock(mutex_);
  std::optional<ClientError> refused;
  if (!status.ok()) refused = to_error(status);
  const bool same_session = session_id == opened_.session_id();
  // Before engage_call_ is reset, or the destructor would take this for the last answer.
  if (force_.answered(refused, same_session, Clock::now())) send_release(lock);
  engage_call_.reset();
  changed_.notify_all();
  work_.notify_all();
}

}  // namespace haptic::client
