#include "server/front/service/response_stream.hpp"

namespace haptic::server {

void ResponseStream::written(bool ok) {
  bool finish_now = false;
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    finish_now = given_up_;
    if (ok) flush();
  }
  if (finish_now) {
    finish(why_);
  } else if (!ok) {
    lost();
  }
}

void ResponseStream::end(const std::optional<Refusal>& why, Ending ending) {
  // The carrier may be done with it before finish() returns.
  const auto keep = shared_from_this();
  {
    const std::lock_guard lock(mutex_);
    if (ended_) return;
    ended_ = true;
    why_ = why;
  }
  // Before the client hears of the end: it may open its next session at once.
  close(ending);
  leave();
  bool finish_now = false;
  {
    const std::lock_guard lock(mutex_);
    given_up_ = true;
    finish_now = !writing_;  // else written() finishes
  }
  if (finish_now) finish(why);
}

void ResponseStream::join(Broadcaster& broadcaster, std::uint32_t tenure) {
  broadcaster.add(shared_from_this(), tenure);
  bool ended = false;
  {
    const std::lock_guard lock(mutex_);
    broadcaster_ = &broadcaster;
    ended = ended_;
  }
  if (ended) leave();  // its end may have come before it joined
}

void ResponseStream::leave() {
  Broadcaster* joined = nullptr;
  {
    const std::lock_guard lock(mutex_);
    joined = broadcaster_;
  }
  if (joined != nullptr) joined->remove(this);
}

}  // namespace haptic::server
