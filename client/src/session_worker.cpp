/// The session's own thread: the user's callbacks, the asking for force, the reconnecting.

#include <algorithm>

#include "error_mapping.hpp"
#include "session_impl.hpp"

namespace haptic::client {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstBackoff{100}, kLongestBackoff{2000};
/// Longest sleep without a look at what is due.
constexpr milliseconds kLook{20};

bool has_force(State state) {
  return state == State::kEngaging || state == State::kEngaged;
}

}  // namespace

/// The user's code runs without our locks; what it throws ends here.
template <typename Callback, typename... Arguments>
void Session::Impl::call(Lock& lock, const Callback& callback, const Arguments&... arguments) {
  if (!callback || closing_) return;
  calling_ = true;
  lock.unlock();
  try {
    callback(arguments...);
  } catch (...) {  // NOLINT(bugprone-empty-catch): the contract: no exception crosses a callback
  }
  lock.lock();
  calling_ = false;
  changed_.notify_all();  // close() may wait for this
}

void Session::Impl::work() {
  Lock lock(mutex_);
  worker_id_ = std::this_thread::get_id();
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
      changed_.wait_for(lock, kLook);
    }
  }
}

void Session::Impl::deliver(Lock& lock) {
  while (!events_.empty() && !closing_) {
    const Event event = std::move(events_.front());
    events_.pop_front();
    call(lock, options_.on_event, event);
  }
  if (!state_pending_ || closing_) return;
  state_pending_ = false;
  if (options_.on_state) call(lock, options_.on_state, hand_out());
}

void Session::Impl::handle_end(Lock& lock) {
  end_pending_ = false;
  const ClientError error = to_error(end_);
  const bool again = options_.reconnect == Reconnect::kWithBackoff;
  if (!again || !options_.re_engage) give_up_force(error);  // force never returns by itself
  reconnecting_ = again;
  backoff_ = kFirstBackoff;
  next_connect_ = Clock::now() + backoff_;
  call(lock, options_.on_disconnect, error, again);
}

void Session::Impl::reconnect(Lock& lock) {
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
  call(lock, options_.on_disconnect, *error, true);
}

}  // namespace haptic::client
