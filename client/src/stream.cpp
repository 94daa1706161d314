#include "stream.hpp"

#include "remote_session.hpp"

namespace haptic::client {

void Stream::start(const v1::OpenSession& open, bool patient) {
  const std::lock_guard lock(mutex_);
  context_.set_wait_for_ready(patient);
  v1::SessionRequest opening;
  *opening.mutable_open() = open;
  stub_.async()->Session(&context_, this);
  AddHold();  // keeps send() legal until the last read failed
  state_ = State::kRunning;
  write(outbox_.put(std::move(opening)));
  StartRead(&incoming_);
  StartCall();
}

void Stream::send(v1::SessionRequest sample) {
  const std::lock_guard lock(mutex_);
  if (state_ == State::kRunning) write(outbox_.put(std::move(sample)));
}

void Stream::write(const v1::SessionRequest* message) {
  if (message != nullptr) StartWrite(message);
}

void Stream::leave(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  if (state_ != State::kRunning) return;
  write(outbox_.leave());
  changed_.wait_for(lock, patience, [this] { return state_ != State::kRunning; });
}

void Stream::break_off() {
  if (state_ == State::kRunning) state_ = State::kBroken;
  outbox_.stop();
  changed_.notify_all();
}

void Stream::OnWriteDone(bool ok) {
  Outbox::Written written;
  {
    const std::lock_guard lock(mutex_);
    written = outbox_.written(ok);
    if (!ok) break_off();
    write(written.next);
  }
  if (written.sample) session_.on_sent(written.replaced);
}

void Stream::OnReadDone(bool ok) {
  if (!ok) {
    const std::lock_guard lock(mutex_);
    break_off();
    RemoveHold();
    return;
  }
  session_.on_message(incoming_);
  const bool at_once = session_.delivers_quickly();
  if (at_once) session_.deliver();
  {
    const std::lock_guard lock(mutex_);
    StartRead(&incoming_);  // of a broken stream too: the read that fails gives the hold back
  }
  // gRPC counts this reaction until it returns: OnDone, and so the destructor, wait for it.
  if (!at_once) session_.deliver();
}

void Stream::cancel() {
  const std::lock_guard lock(mutex_);
  if (state_ != State::kNew) break_off();
  context_.TryCancel();  // of a call that is yet to start: it then ends at once
}

void Stream::OnDone(const grpc::Status& status) {
  session_.on_done(status);
  const std::lock_guard lock(mutex_);
  state_ = State::kDone;
  changed_.notify_all();
}

void Stream::end() {
  cancel();
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return state_ == State::kDone || state_ == State::kNew; });
}

}  // namespace haptic::client
