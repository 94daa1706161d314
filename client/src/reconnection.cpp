#include "reconnection.hpp"

#include <algorithm>

namespace haptic::client {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstDelay{100}, kLongestDelay{500};

/// True if waiting can change the answer to the same opening: a server comes back, a lease runs
/// out, a session ends. A wrong argument stays wrong.
bool may_pass(ErrorReason reason) {
  return reason == ErrorReason::kUnreachable || reason == ErrorReason::kTimeout ||
         reason == ErrorReason::kLeaseHeld || reason == ErrorReason::kNotReady ||
         reason == ErrorReason::kClosed;
}

}  // namespace

bool Reconnection::open() const noexcept {
  return state_ == State::kOpen || state_ == State::kLeaseLost;
}

bool Reconnection::begin() noexcept {
  if (!closed()) state_ = State::kOpening;
  return !closed();
}

void Reconnection::opened() noexcept {
  if (state_ != State::kOpening) return;
  state_ = State::kOpen;
  delay_ = {};
}

void Reconnection::lease_lost() noexcept {
  if (state_ == State::kOpen) state_ = State::kLeaseLost;
}

void Reconnection::ended(const ClientError& why) {
  if (state_ != State::kOpening && !open()) return;
  state_ = State::kEnded;
  why_ = why;
}

bool Reconnection::retry(TimePoint now) {
  if (state_ != State::kEnded) return state_ == State::kWaiting;
  const bool first = delay_ == milliseconds(0);
  if (!wanted_ || (!first && !may_pass(why_.reason()))) {
    state_ = State::kOver;
    return false;
  }
  state_ = State::kWaiting;
  due_ = now + delay_;
  delay_ = first ? kFirstDelay : std::min(2 * delay_, kLongestDelay);
  return true;
}

Reconnection::TimePoint Reconnection::due() const noexcept {
  return state_ == State::kWaiting ? due_ : TimePoint::max();
}

}  // namespace haptic::client
