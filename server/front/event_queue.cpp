#include "server/front/event_queue.hpp"

#include <algorithm>
#include <string>

namespace haptic::server {

void EventQueue::push(const DeviceEvent& event) {
  const std::lock_guard lock(mutex_);
  if (events_.size() >= kCapacity) {
    // A staleness level is also a field of every state: it is lost first.
    const auto oldest = std::find_if(events_.begin(), events_.end(), [](const DeviceEvent& e) {
      return e.kind == DeviceEvent::Kind::kStaleness;
    });
    events_.erase(oldest == events_.end() ? events_.begin() : oldest);
    ++dropped_;
    ++dropped_untold_;
  }
  events_.push_back(event);
}

std::optional<DeviceEvent> EventQueue::pop() {
  const std::lock_guard lock(mutex_);
  if (events_.empty()) return std::nullopt;
  DeviceEvent event = events_.front();
  events_.pop_front();
  if (dropped_untold_ > 0) {
    event.message = event.message.str() + " (" + std::to_string(dropped_untold_) +
                    " older events were dropped: this stream was not read)";
    dropped_untold_ = 0;
  }
  return event;
}

std::uint64_t EventQueue::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

}  // namespace haptic::server
