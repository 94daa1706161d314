/// Takes the server's messages on gRPC's threads: into fields, and a state to the user at once.

#include <algorithm>

#include "convert.hpp"
#include "remote_session.hpp"
#include "udp_carrier.hpp"

namespace haptic::client {

namespace {

/// After this many calls of on_state in a row that each took less than kQuick, the next read waits
/// for on_state. One slow call ends that, so that no state grows old in the transport's buffers.
constexpr std::chrono::microseconds kQuick{200};
constexpr int kTrusted = 100;

}  // namespace

void RemoteSession::on_message(const v1::SessionResponse& message) {
  const std::lock_guard lock(mutex_);
  const bool is_opening = message.message_case() == v1::SessionResponse::kOpened;
  // An answer that comes after connect() gave up on it opens nothing.
  const bool expected =
      is_opening ? reconnection_.state() == Reconnection::State::kOpening : reconnection_.open();
  if (!expected) return;
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

/// The thread that finds a state which on_state has not seen hands it over, then what came in the
/// meantime: a slow callback gets the newest only, and no thread is woken on the way to it.
void RemoteSession::deliver() {
  if (!options_.on_state) return;
  Lock lock(mutex_);
  while (!on_state_.busy && !reconnection_.closed() && states_.to_call_back()) {
    const Clock::time_point begin = Clock::now();
    call_user(lock, on_state_, options_.on_state, states_.give());
    quick_in_a_row_ = Clock::now() - begin < kQuick ? std::min(quick_in_a_row_ + 1, kTrusted) : 0;
  }
}

bool RemoteSession::delivers_quickly() const {
  const std::lock_guard lock(mutex_);
  return quick_in_a_row_ == kTrusted;
}

void RemoteSession::received(const v1::SessionOpened& opened) {
  opened_ = opened;
  if (!opened.resumed()) {
    states_.restart();
    was_free_ = false;
    force_.owe_release(false);
  }
  earlier_ = statistics_;
  reconnection_.opened();
}

void RemoteSession::received(const v1::DeviceState& state) {
  const bool had_force = has_force(states_.newest().state);
  if (!states_.take(to_state(state))) return;
  const DeviceState& newest = states_.newest();
  round_trip_.used(newest.proxy_seq_used, newest.received);
  if (force_.wanted() && had_force && !has_force(newest.state)) work_.notify_all();
  // A fault may have latched while the stream was down: its event is then never seen.
  if (newest.state == Lifecycle::kFault) force_.fault_seen(newest.received);
}

void RemoteSession::received(const v1::Event& event) {
  read(event, events_.emplace_back());
  if (event.kind() != v1::Event::KIND_TRANSPORT) newest_event_ns_ = event.server_time_ns();
  work_.notify_all();
  // The end of an earlier session's lease may still be told to a session that opens just then.
  const bool of_this_lease = event.lease_epoch() == opened_.lease_epoch();
  if (event.kind() == v1::Event::KIND_LEASE_EXPIRED && !options_.observer && of_this_lease) {
    reconnection_.lease_lost();
  }
  if (event.reason() == "LEASE_PREEMPTED" && of_this_lease) {
    reconnection_.lease_lost();
    force_.give_up({ErrorReason::kLeaseHeld, event.message()});
  }
  if (event.kind() == v1::Event::KIND_FAULT) {
    // Clearing a fault, perhaps an emergency stop, must not start a motor.
    force_.give_up({ErrorReason::kNotReady, "fault " + event.reason() + ": " + event.message()});
  }
  if (event.kind() == v1::Event::KIND_LOST && !options_.re_engage) {
    force_.give_up({ErrorReason::kNotReady, "force was lost: " + event.message()});
  }
}

void RemoteSession::received(const v1::SampleAck& ack) {
  statistics_.accepted = earlier_.accepted + ack.accepted();
  statistics_.rejected_old = earlier_.rejected_old + ack.rejected_old();
  statistics_.rejected_invalid = earlier_.rejected_invalid + ack.rejected_invalid();
  statistics_.backlog = earlier_.backlog + ack.conflated_backlog();
  statistics_.last_rejection = ack.last_rejection();
}

void RemoteSession::on_sent(std::uint64_t replaced) {
  const std::lock_guard lock(mutex_);
  ++statistics_.sent;
  statistics_.conflated += replaced;
}

void RemoteSession::on_done(const grpc::Status& status) {
  const std::lock_guard lock(mutex_);
  reconnection_.ended(to_error(status));
  changed_.notify_all();
  work_.notify_all();
}

}  // namespace haptic::client
