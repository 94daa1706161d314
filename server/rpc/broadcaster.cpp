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

Broadcaster::Broadcaster(Telemetry& telemetry, std::size_t index, WatchBudget& budget)
    : telemetry_(telemetry), index_(index), budget_(budget) {
  telemetry_.add(index_, this);
}

Broadcaster::~Broadcaster() {
  telemetry_.remove(index_, this);
  telemetry_.watch(-static_cast<int>(controllers_.size()));
}

void Broadcaster::add(Rank rank, std::shared_ptr<Subscriber> subscriber) {
  const std::lock_guard lock(mutex_);
  if (rank == Rank::kController) telemetry_.watch(+1);
  (rank == Rank::kController ? controllers_ : others_).push_back(std::move(subscriber));
}

void Broadcaster::remove(const Subscriber* subscriber) {
  const auto is_it = [&](const std::shared_ptr<Subscriber>& s) { return s.get() == subscriber; };
  std::vector<std::shared_ptr<Subscriber>> released;  // destroyed when the mutex is free again
  const std::lock_guard lock(mutex_);
  for (auto* list : {&controllers_, &others_}) {
    const auto found = std::find_if(list->begin(), list->end(), is_it);
    if (found == list->end()) continue;
    if (list == &controllers_) telemetry_.watch(-1);
    released.push_back(std::move(*found));
    list->erase(found);
  }
}

void Broadcaster::on_newest(const core::TickRecord& record) {
  const std::lock_guard lock(mutex_);
  frame_.begin(record);
  for (const auto& controller : controllers_) controller->offer(record, frame_, true);

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
