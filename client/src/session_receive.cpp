/// What the server says, on gRPC's threads: into fields, and a state to the user at once.

#include <algorithm>

#include "convert.hpp"
#include "session_impl.hpp"

namespace haptic::client {

namespace {

/// A FAULT state this soon after the user asked for force may be older than the ClearFault that the
/// user had sent before; one that is still seen later is not.
constexpr std::chrono::milliseconds kFaultMayBeOld{250};

/// A user's callback that was done in this time so often in a row may keep the next message waiting;
/// one that was not loses that trust at once, and no state grows old in the transport's buffers.
constexpr std::chrono::microseconds kQuick{200};
constexpr int kTrusted = 100;

}  // namespace

void Session::Impl::on_message(const v1::SessionResponse& message) {
  const std::lock_guard lock(mutex_);
  const bool is_opening = message.message_case() == v1::SessionResponse::kOpened;
  // An answer that comes after connect() gave up on it opens nothing.
  if (phase_ != (is_opening ? Phase::kOpening : Phase::kOpen)) return;
  switch (message.message_case()) {
    case v1::SessionResponse::kOpened:
      received(message.opened());
      break;
    case v1::SessionResponse::kState:
      received(message.state());
      break;
    case v1::SessionResponse::kEvent:
      received(message.event());
      break;
    case v1::SessionResponse::kAck:
      received(message.ack());
      break;
    case v1::SessionResponse::kUdp:
      if (udp_) udp_->rekey(message.udp());
      break;
    case v1::SessionResponse::MESSAGE_NOT_SET:
      return;  // of a newer protocol
  }
  changed_.notify_all();
}

/// Whoever finds a state that on_state has not seen hands it over, and then what came meanwhile: a
/// slow callback gets the newest only, and no thread's wake-up lies between arrival and callback.
void Session::Impl::deliver() {
  if (!options_.on_state) return;
  Lock lock(mutex_);
  while (state_pending_ && !states_.busy && !closing_) {
    state_pending_ = false;
    const Clock::time_point begin = Clock::now();
    call(lock, states_, options_.on_state, hand_out());
    quick_in_a_row_ = Clock::now() - begin < kQuick ? std::min(quick_in_a_row_ + 1, kTrusted) : 0;
  }
}

bool Session::Impl::delivers_quickly() const {
  const std::lock_guard lock(mutex_);
  return quick_in_a_row_ == kTrusted;
}

void Session::Impl::received(const v1::SessionOpened& opened) {
  opened_ = opened;
  if (!opened.resumed()) {
    // A server that was started anew counts its ticks and our samples from the beginning.
    newest_ = {};
    waited_seq_ = 0;
    handed_seq_ = 0;
    handed_x_probe_.clear();
    state_pending_ = false;
    release_due_ = false;
  }
  earlier_ = statistics_;
  lease_lost_ = false;
  phase_ = Phase::kOpen;
}

void Session::Impl::received(const v1::DeviceState& state) {
  // The other carrier was faster.
  if (newest_.seq != 0 && state.seq() <= newest_.seq) return;
  const bool had_force = has_force(newest_.state);
  newest_ = to_state(state);
  state_pending_ = true;
  if (want_force_ && had_force && !has_force(newest_.state)) work_.notify_all();
  // A fault may have latched while the stream was down: its event is then never seen.
  if (newest_.state == Lifecycle::kFault && newest_.received - asked_at_ > kFaultMayBeOld) {
    give_up_force({ErrorReason::kNotReady, "the device is in FAULT"});
  }
}

void Session::Impl::received(const v1::Event& event) {
  events_.push_back(to_event(event));
  work_.notify_all();
  // A predecessor's end may still be told to a session that opens at that very moment.
  if (event.kind() == v1::Event::KIND_LEASE_EXPIRED && !options_.observer &&
      event.lease_epoch() == opened_.lease_epoch()) {
    lease_lost_ = true;
  }
  if (event.reason() == "LEASE_PREEMPTED" && event.lease_epoch() == opened_.lease_epoch()) {
    lease_lost_ = true;
    give_up_force({ErrorReason::kLeaseHeld, event.message()});
  }
  if (event.kind() == v1::Event::KIND_FAULT) {
    // Whoever clears it, perhaps an emergency stop, must not start a motor by that.
    give_up_force({ErrorReason::kNotReady, "fault " + event.reason() + ": " + event.message()});
  }
  if (event.kind() == v1::Event::KIND_LOST && !options_.re_engage) {
    give_up_force({ErrorReason::kNotReady, "force was lost: " + event.message()});
  }
}

void Session::Impl::received(const v1::SampleAck& ack) {
  statistics_.accepted = earlier_.accepted + ack.accepted();
  statistics_.rejected_old = earlier_.rejected_old + ack.rejected_old();
  statistics_.rejected_invalid = earlier_.rejected_invalid + ack.rejected_invalid();
  statistics_.backlog = earlier_.backlog + ack.conflated_backlog();
  statistics_.last_rejection = ack.last_rejection();
}

void Session::Impl::on_sent(std::uint64_t samples_replaced) {
  const std::lock_guard lock(mutex_);
  ++statistics_.sent;
  statistics_.conflated += samples_replaced;
}

void Session::Impl::on_done(const grpc::Status& status) {
  const std::lock_guard lock(mutex_);
  // While opening connect() deals with it; a stream that we gave up is dealt with already.
  if (phase_ == Phase::kOpen) end_pending_ = true;
  if (phase_ != Phase::kDone) end_ = status;
  phase_ = Phase::kDone;
  changed_.notify_all();
  work_.notify_all();
}

}  // namespace haptic::client
