/// The session's own thread: brings events and the end of the stream to the user, asks for force,
/// reconnects.

#include <algorithm>

#include "remote_session.hpp"

namespace haptic::client {

void RemoteSession::work() {
  Lock lock(mutex_);
  while (!reconnection_.closed()) {
    deliver_events(lock);
    if (reconnection_.closed()) break;
    const Clock::time_point now = Clock::now();
    if (reconnection_.state() == Reconnection::State::kEnded) {
      handle_end(lock);
    } else if (now >= reconnection_.due()) {
      reconnect(lock);
    } else if (force_.owes_release() && reconnection_.open() && !release_call_) {
      send_release(lock);
    } else if (now >= engage_due()) {
      send_engage(lock);
    } else if (events_.empty()) {
      const Clock::time_point due = std::min(reconnection_.due(), engage_due());
      due == Clock::time_point::max() ? work_.wait(lock) : void(work_.wait_until(lock, due));
    }
  }
}

void RemoteSession::deliver_events(Lock& lock) {
  while (!events_.empty() && !reconnection_.closed()) {
    const Event event = std::move(events_.front());
    events_.pop_front();
    call_user(lock, on_event_or_end_, options_.on_event, event);
  }
}

void RemoteSession::handle_end(Lock& lock) {
  stop_udp(lock);
  const ClientError error = reconnection_.why();
  const bool again = reconnection_.retry(Clock::now());      // at once: force may still be on
  if (!again || !options_.re_engage) force_.give_up(error);  // force never returns by itself
  changed_.notify_all();
  call_user(lock, on_event_or_end_, options_.on_disconnect, error, again);
}

void RemoteSession::reconnect(Lock& lock) {
  const std::shared_ptr<Stream> old = std::move(stream_);
  stream_.reset();
  lock.unlock();
  // publish() may hold the old stream for a moment longer than this function. Its end must come
  // now, so that it is not taken for the end of the next stream.
  if (old) old->end();
  std::optional<ClientError> error;
  try {
    connect(true);
  } catch (const ClientError& failed) {
    error = failed;
  }
  lock.lock();
  force_.ask_at(Clock::now());
  if (!error || reconnection_.retry(Clock::now())) return;  // on_disconnect said that this goes on
  force_.give_up(*error);
  changed_.notify_all();
  call_user(lock, on_event_or_end_, options_.on_disconnect, *error, false);
}

}  // namespace haptic::client
