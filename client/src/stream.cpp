#include "stream.hpp"

namespace haptic::client {

Stream::Stream(v1::HapticService::Stub& stub, StreamSink& sink) : stub_(stub), sink_(sink) {}

Stream::~Stream() {
  end();
}

void Stream::start(const v1::OpenSession& open) {
  const std::lock_guard lock(mutex_);
  *outgoing_.mutable_open() = open;
  stub_.async()->Session(&context_, this);
  AddHold();
  started_ = held_ = writing_ = true;
  StartWrite(&outgoing_);
  StartRead(&incoming_);
  StartCall();
}

void Stream::send(const v1::ProxySample& sample) {
  v1::SessionRequest request;
  *request.mutable_proxy() = sample;
  keep_newest(std::move(request));
}

void Stream::send(const v1::TrackerSample& sample) {
  v1::SessionRequest request;
  *request.mutable_tracker() = sample;
  keep_newest(std::move(request));
}

void Stream::keep_newest(v1::SessionRequest request) {
  const std::lock_guard lock(mutex_);
  if (!started_ || broken_ || leaving_) return;
  if (pending_) ++replaced_;
  pending_ = std::move(request);
  if (!writing_) write_locked();
}

void Stream::write_locked() {
  outgoing_ = std::move(*pending_);
  pending_.reset();
  writing_ = true;
  StartWrite(&outgoing_);
}

void Stream::leave(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  if (!started_ || broken_ || leaving_) return;
  leaving_ = true;
  pending_.reset();
  if (!writing_) write_leave_locked();
  changed_.wait_for(lock, patience, [this] { return done_ || broken_; });
}

void Stream::write_leave_locked() {
  outgoing_.mutable_leave();
  writing_ = true;
  StartWrite(&outgoing_);
}

void Stream::OnWriteDone(bool ok) {
  std::uint64_t replaced = 0;
  bool was_sample = false;  // or the opening
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    was_sample = outgoing_.has_proxy() || outgoing_.has_tracker();
    if (ok && was_sample) replaced = std::exchange(replaced_, 0);
    if (!ok) {
      broken_ = true;
    } else if (leaving_ && !outgoing_.has_leave() && !broken_) {
      write_leave_locked();
    } else if (pending_ && !broken_) {
      write_locked();
    }
  }
  if (ok && was_sample) sink_.on_sent(replaced);
}

void Stream::OnReadDone(bool ok) {
  if (!ok) {
    const std::lock_guard lock(mutex_);
    broken_ = true;
    changed_.notify_all();
    if (std::exchange(held_, false)) RemoveHold();
    return;
  }
  sink_.on_message(incoming_);
  const bool at_once = sink_.delivers_quickly();
  if (at_once) sink_.deliver();
  {
    const std::lock_guard lock(mutex_);
    if (!broken_ || held_) StartRead(&incoming_);
  }
  // gRPC counts this reaction until it returns: OnDone, and so our destructor, wait for it.
  if (!at_once) sink_.deliver();
}

void Stream::cancel() {
  const std::lock_guard lock(mutex_);
  if (started_) broken_ = true;
  context_.TryCancel();  // of a call that is yet to start: it then ends at once
  // The pending read now fails and gives the hold back.
}

void Stream::OnDone(const grpc::Status& status) {
  sink_.on_done(status);
  const std::lock_guard lock(mutex_);
  done_ = true;
  changed_.notify_all();
}

void Stream::end() {
  cancel();
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return done_ || !started_; });
}

}  // namespace haptic::client
