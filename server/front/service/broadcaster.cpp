#include "server/front/service/broadcaster.hpp"

#include <algorithm>
#include <utility>

namespace haptic::server {

void WatchBudget::refill(core::TimePoint now) noexcept {
  // The rest is kept for 4 ms: long enough for a drain that was late by a few ticks, too
  // short to pay for a burst that the controller would feel.
  const double most = std::max(1.0, rate_ * 4e-3);
  tokens_ = started_ ? std::min(most, tokens_ + rate_ * core::seconds(now - last_)) : most;
  last_ = now;
  started_ = true;
}

void Broadcaster::add(std::shared_ptr<Subscriber> subscriber, std::uint32_t tenure) {
  const std::lock_guard lock(mutex_);
  entries_.push_back({tenure, std::move(subscriber)});
}

void Broadcaster::remove(const Subscriber* subscriber) {
  std::shared_ptr<Subscriber> released;  // destroyed when the mutex is free again
  const std::lock_guard lock(mutex_);
  const auto entry = std::find_if(entries_.begin(), entries_.end(),
                                  [&](const Entry& e) { return e.stream.get() == subscriber; });
  if (entry == entries_.end()) return;
  released = std::move(entry->stream);
  entries_.erase(entry);
}

void Broadcaster::on_newest(std::size_t device, const SerialisedState& state) {
  if (device != device_) return;
  std::vector<std::shared_ptr<Subscriber>> over;
  {
    const std::lock_guard lock(mutex_);
    send(state);
    over.swap(over_);
  }
  for (const auto& stream : over) stream->lease_over();
}

void Broadcaster::send(const SerialisedState& state) {
  StateFrame frame(state);
  others_.clear();
  for (Entry& entry : entries_) {
    // A state from before the tenure knows an earlier one, and ends nothing.
    const bool over =
        state.tenure > entry.tenure || (state.tenure == entry.tenure && !state.lease_held);
    if (over && entry.tenure != 0) {
      entry.tenure = 0;
      over_.push_back(entry.stream);
    }
    if (entry.tenure == 0) {
      others_.push_back(entry.stream.get());
    } else {
      entry.stream->offer(state, frame, true);
    }
  }

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
    if (others_[at]->offer(state, frame, allowed)) budget_.take();
  }
}

}  // namespace haptic::server
