/// The session's own thread: events and the end to the user, the asking for force, the reconnecting.

#include <algorithm>

#include "error_mapping.hpp"
#include "session_impl.hpp"

namespace haptic::client {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstBackoff{100}, kLongestBackoff{2000};

/// What another attempt at the same opening may find changed: a server that comes back, a lease that
/// runs out, sessions that end. A wrong argument stays wrong.
bool may_pass(ErrorReason reason) {
  return reason == ErrorReason::kUnreachable || reason == ErrorReason::kTimeout ||
         reason == ErrorReason::kLeaseHeld || reason == ErrorReason::kNotReady ||
         reason == ErrorReason::kClosed;
}

}  // namespace

void Session::Impl::work() {
  Lock lock(mutex_);
  while (!closing_) {
    deliver_events(lock);
    if (closing_) break;
    if (end_pending_) {
      handle_end(lock);
    } else if (reconnecting_ && Clock::now() >= next_connect_) {
      reconnect(lock);
    } else if (release_due_ &&
               phase_ == Phase::kOpen) {  // resumed, by an opening already under way
      release_due_ = false;
      release_again(lock);
    } else if (force_due() && Clock::now() >= next_engage_) {
      ask_for_force(lock);
    } else if (events_.empty()) {
      const Clock::time_point due = next_due();
      due == Clock::time_point::max() ? work_.wait(lock) : void(work_.wait_until(lock, due));
    }
  }
}

bool Session::Impl::force_due() const {
  if (lease_lost_ && comes_back_with_force()) return false;  // in vain, until the next sample
  return want_force_ && phase_ == Phase::kOpen && !engage_call_ && !has_force(newest_.state);
}

Session::Impl::Clock::time_point Session::Impl::next_due() const {
  Clock::time_point due = Clock::time_point::max();
  if (reconnecting_) due = next_connect_;
  if (force_due()) due = std::min(due, next_engage_);
  return due;
}

void Session::Impl::deliver_events(Lock& lock) {
  while (!events_.empty() && !closing_) {
    const Event event = std::move(events_.front());
    events_.pop_front();
    call(lock, events_and_end_, options_.on_event, event);
  }
}

void Session::Impl::handle_end(Lock& lock) {
  end_pending_ = false;
  stop_udp(lock);
  const ClientError error = to_error(end_);
  const bool again = options_.reconnect == Reconnect::kWithBackoff;
  if (!again || !options_.re_engage) give_up_force(error);  // force never returns by itself
  reconnecting_ = again;
  backoff_ = kFirstBackoff;
  next_connect_ = Clock::now();  // while the force is still on it can be resumed
  changed_.notify_all();
  call(lock, events_and_end_, options_.on_disconnect, error, again);
}

void Session::Impl::reconnect(Lock& lock) {
  std::shared_ptr<Stream> old = std::move(stream_);
  lock.unlock();
  // Not by its destructor: publish() may hold it for a moment longer, and its end must not be taken
  // for the end of the next stream.
  if (old) old->end();
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
  next_connect_ = Clock::now() + backoff_;
  backoff_ = std::min(backoff_ * 2, kLongestBackoff);
  if (may_pass(error->reason())) return;  // on_disconnect has said that this goes on
  reconnecting_ = false;
  give_up_force(*error);
  changed_.notify_all();
  call(lock, events_and_end_, options_.on_disconnect, *error, false);
}

}  // namespace haptic::client
