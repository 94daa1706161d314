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

Broadcaster::Broadcaster(Telemetry& telemetry, std::size_t index, WatchBudget budget,
                         const DeviceSessions& sessions)
    : telemetry_(telemetry),
      index_(index),
      budget_(budget),
      sessions_(sessions),
      frame_(StateMessage(sessions.unit().config(), sessions.coupling_softness())) {
  telemetry_.add(index_, this);
}

Broadcaster::~Broadcaster() {
  telemetry_.remove(index_, this);
  telemetry_.watch(-static_cast<int>(controllers_.size()));
}

void Broadcaster::add(std::shared_ptr<Subscriber> subscriber, std::uint32_t epoch) {
  const std::lock_guard lock(mutex_);
  if (epoch == 0) {
    others_.push_back(std::move(subscriber));
  } else {
    telemetry_.watch(+1);
    controllers_.push_back({epoch, std::move(subscriber)});
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
    telemetry_.watch(-1);
    released = std::move(controller->stream);
    controllers_.erase(controller);
  }
}

void Broadcaster::demote_expired(const core::CommandSnapshot& command) {
  // A record from before the grant knows an earlier epoch, and ends nothing.
  const auto over = [&](const Controller& c) {
    return command.lease_epoch > c.epoch || (command.lease_epoch == c.epoch && !command.lease_held);
  };
  for (Controller& controller : controllers_) {
    if (!over(controller)) continue;
    telemetry_.watch(-1);
    others_.push_back(std::move(controller.stream));
  }
  std::erase_if(controllers_, [](const Controller& c) { return c.stream == nullptr; });
}

void Broadcaster::on_newest(const core::TickRecord& record) {
  const std::lock_guard lock(mutex_);
  frame_.begin(record, sessions_.stamp(record));
  demote_expired(record.input.command);
  for (const Controller& controller : controllers_) controller.stream->offer(record, frame_, true);

  budget_.refill(record.input.now);
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
    if (others_[at]->offer(record, frame_, allowed)) budget_.take();
  }
}

}  // namespace haptic::server
