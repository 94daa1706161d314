#include "server/owner/link/publisher.hpp"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "server/crossing/link_messages.hpp"

namespace haptic::server {

Publisher::Publisher(const Owner& owner, std::function<void(const Answer&)> local)
    : owner_(owner),
      local_(std::move(local)),
      memory_("haptic-owner", OwnersPages::bytes(owner.devices().size())),
      pages_(*static_cast<OwnersPages*>(memory_.data())),
      told_(owner.devices().size()) {
  for (std::size_t i = 0; i < owner_.devices().size(); ++i) status(i);
}

bool Publisher::expect_answer(std::uint64_t id) {
  // An honest front has no more open, so no stop of it is ever refused.
  constexpr std::size_t kMost = kMostOpenRequests + kMostOpenStops + kMostDevices;
  const std::lock_guard lock(mutex_);
  return open_.size() < kMost && open_.insert(id).second;
}

void Publisher::forget_answer(std::uint64_t id) {
  const std::lock_guard lock(mutex_);
  open_.erase(id);
}

void Publisher::forget_answers() {
  const std::lock_guard lock(mutex_);
  open_.clear();
}

void Publisher::status(std::size_t device) {
  // Asked for under the lock, so that an older status never replaces a newer one.
  const std::lock_guard lock(mutex_);
  pages_.devices[device].status.publish(owner_.status(device));
}

void Publisher::on_answer(const Answer& answer) {
  if ((answer.id & kLocalIds) != 0) return local_(answer);
  // A client that asks after the answer sees what it changed.
  for (std::size_t i = 0; i < owner_.devices().size(); ++i) status(i);
  {
    const std::lock_guard lock(mutex_);
    open_.erase(answer.id);
    pages_.answers.publish(answer);
  }
  ring();
}

void Publisher::on_event(std::size_t device, const DeviceEvent& event) {
  pages_.events.publish({static_cast<std::uint32_t>(device), event});
  told_[device].changed.store(true);
}

void Publisher::on_newest(std::size_t device, const SerialisedState& state) {
  pages_.devices[device].state.publish(state);
  ring();
  Told& told = told_[device];
  if (!told.changed.exchange(false) && state.now - told.at < kStatusEvery) return;
  told.at = state.now;
  status(device);
}

void Publisher::ring() noexcept {
  pages_.rings.fetch_add(1, std::memory_order_release);
  // One, whatever number of threads a front has wait there: an honest one has one.
  syscall(SYS_futex, &pages_.rings, FUTEX_WAKE, 1, nullptr, nullptr, 0);
}

}  // namespace haptic::server
