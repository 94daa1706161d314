#include "outbox.hpp"

#include <utility>

namespace haptic::client {

const Outbox::Message* Outbox::put(Message message) {
  if (state_ == State::kIdle) {
    state_ = State::kWriting;
    current_ = std::move(message);
    return &current_;
  }
  if (state_ == State::kWriting) {
    if (waiting_) ++replaced_;
    waiting_ = std::move(message);
  }
  return nullptr;
}

const Outbox::Message* Outbox::leave() {
  if (state_ == State::kIdle) return farewell();
  if (state_ == State::kWriting) state_ = State::kLeaving;
  return nullptr;
}

const Outbox::Message* Outbox::farewell() {
  state_ = State::kOver;
  current_.mutable_leave();
  return &current_;
}

Outbox::Written Outbox::written(bool ok) {
  Written written;
  written.sample = ok && (current_.has_proxy() || current_.has_tracker());
  if (written.sample) written.replaced = std::exchange(replaced_, 0);
  if (!ok) {
    state_ = State::kOver;
  } else if (state_ == State::kLeaving) {
    written.next = farewell();
  } else if (state_ == State::kWriting && waiting_) {
    current_ = std::move(*waiting_);
    waiting_.reset();
    written.next = &current_;
  } else if (state_ == State::kWriting) {
    state_ = State::kIdle;
  }
  return written;
}

}  // namespace haptic::client
