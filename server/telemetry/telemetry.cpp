#include "server/telemetry/telemetry.hpp"

#include <pthread.h>

#include <algorithm>
#include <csignal>

namespace haptic::server {

struct Telemetry::Channel {
  explicit Channel(DeviceUnit& u) : unit(u) {}

  DeviceUnit& unit;
  /// Held while listeners are called, so that remove() returns only when none is being called.
  /// Recursive: a listener may remove itself.
  std::recursive_mutex listening;
  std::vector<RecordListener*> listeners;
  mutable std::mutex newest_mutex;
  core::TickRecord newest;
};

Telemetry::Telemetry(std::vector<DeviceUnit*> units) {
  for (DeviceUnit* unit : units) channels_.push_back(std::make_unique<Channel>(*unit));
}

Telemetry::~Telemetry() { stop(); }

void Telemetry::start() {
  if (thread_.joinable()) return;
  stopping_.store(false);
  thread_ = std::thread([this] {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, nullptr);
    pthread_setname_np(pthread_self(), "haptic-drain");
    std::uint32_t heard = bell_.load(std::memory_order_acquire);
    while (!stopping_.load(std::memory_order_acquire)) {
      drain();
      bell_.wait(heard, std::memory_order_acquire);
      heard = bell_.load(std::memory_order_acquire);
    }
    drain();
  });
}

void Telemetry::stop() {
  if (!thread_.joinable()) return;
  stopping_.store(true, std::memory_order_release);
  wake();
  thread_.join();
}

void Telemetry::wake() noexcept {
  bell_.fetch_add(1, std::memory_order_release);
  bell_.notify_one();  // a futex call where the drain sleeps, nothing otherwise; takes no lock
}

void Telemetry::drain() {
  for (const auto& channel : channels_) {
    bool any = false;
    const std::lock_guard lock(channel->listening);
    const auto tell = [&channel](auto call) {
      // By index: a listener may add or remove while it is called.
      for (std::size_t i = 0; i < channel->listeners.size(); ++i) {
        if (channel->listeners[i] != nullptr) call(*channel->listeners[i]);
      }
    };
    while (const core::TickRecord* record = channel->unit.records.front()) {
      {
        const std::lock_guard newest_lock(channel->newest_mutex);
        channel->newest = *record;
      }
      tell([record](RecordListener& listener) { listener.on_record(*record); });
      channel->unit.records.pop();
      any = true;
    }
    if (any) {
      tell([&channel](RecordListener& listener) { listener.on_newest(channel->newest); });
    }
    std::erase(channel->listeners, nullptr);
  }
}

void Telemetry::add(std::size_t unit, RecordListener* listener) {
  Channel& channel = *channels_.at(unit);
  const std::lock_guard lock(channel.listening);
  channel.listeners.push_back(listener);
}

void Telemetry::remove(std::size_t unit, RecordListener* listener) {
  Channel& channel = *channels_.at(unit);
  const std::lock_guard lock(channel.listening);
  std::replace(channel.listeners.begin(), channel.listeners.end(), listener,
               static_cast<RecordListener*>(nullptr));
}

core::TickRecord Telemetry::newest(std::size_t unit) const {
  const Channel& channel = *channels_.at(unit);
  const std::lock_guard lock(channel.newest_mutex);
  return channel.newest;
}

}  // namespace haptic::server
