#include "server/rpc/broadcaster.hpp"

#include <algorithm>
#include <utility>

namespace haptic::server {

void WatchBudget::refill(core::TimePoint now) noexcept {
  // What is left over is kept for 4 ms: long enough for a drain that was late by a few ticks, too
  // short to pay for a burst that the controller would feel.
  const double most = std::max(1.0, rate_ * 4e-3);
  tokens_ = started_ ? std::min(most, tokens_ + rate_ * core::seconds(now - last_)) : most;
  last_ = now;
  started_ = true;
}

Broadcaster::Broadcaster(WatchBudget budget, const DeviceFacts& device)
    : budget_(budget), frame_(StateMessage(*device.config, device.coupling_softness)) {}

void Broadcaster::add(std::shared_ptr<Subscriber> subscriber, std::uint32_t tenure) {
  const std::lock_guard lock(mutex_);
  if (tenure == 0) {
    others_.push_back(std::move(subscriber));
  } else {
    controllers_.push_back({tenure, std::move(subscriber)});
  }
}

void Broadcaster::remove(const Subscriber* subscriber) {
  std::shared_ptr<Subscriber> released;  // destroyed when the mutex is free again
  const std::lock_guard lock(mutex_);
  const auto other = std::find_if(others_.begin(), others_.end(),
                                  [&](const auto& s) { return s.get() == subscriber; });
  if (other != others_.end()) {
    released = std::move(*other);
    others_.erase(other);
  }
  const auto controller =
      std::find_if(controllers_.begin(), controllers_.end(),
                   [&](const Controller& c) { return c.stream.get() == subscriber; });
  if (controller != controllers_.end()) {
    released = std::move(controller->stream);
    controllers_.erase(controller);
  }
}

void Broadcaster::demote_expired(const StateRecord& state) {
  // A state from before the tenure knows an earlier one, and ends nothing.
  const auto over = [&](const Controller& c) {
    return state.tenure > c.tenure || (state.tenure == c.tenure && !state.lease_held);
  };
  for (Controller& controller : controllers_) {
    if (over(controller)) others_.push_back(std::move(controller.stream));
  }
  std::erase_if(controllers_, [](const Controller& c) { return c.stream == nullptr; });
}

void Broadcaster::on_newest(const StateRecord& state) {
  const std::lock_guard lock(mutex_);
  frame_.begin(state);
  demote_expired(state);
  for (const Controller& controller : controllers_) controller.stream->offer(state, frame_, true);

  budget_.refill(state.now);
  const std::size_t n = others_.size();
  const std::size_t start = n > 0 ? turn_ % n : 0;
  bool went_short = false;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t at = (start + i) % n;
    const bool allowed = budget_.left();
    if (!allowed && !went_short) {
      went_short = true;
      turn_ = at;
    }
    if (others_[at]->offer(state, frame_, allowed)) budget_.take();
  }
}

}  // namespace haptic::server
