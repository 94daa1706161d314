#include "server/rpc/every.hpp"

#include <utility>

namespace haptic::server {

Every::Every(std::chrono::milliseconds period, std::function<void()> look)
    : period_(period), look_(std::move(look)) {
  const std::lock_guard lock(mutex_);
  set_alarm();
}

Every::~Every() {
  std::unique_lock lock(mutex_);
  stopping_ = true;
  alarm_->Cancel();
  idle_.wait(lock, [&] { return !waiting_; });
}

void Every::set_alarm() {
  waiting_ = true;
  alarm_ = std::make_unique<grpc::Alarm>();
  alarm_->Set(std::chrono::system_clock::now() + period_, [this](bool rang) {
    if (rang) look_();
    const std::lock_guard lock(mutex_);
    if (stopping_ || !rang) {
      waiting_ = false;
      idle_.notify_all();
    } else {
      set_alarm();
    }
  });
}

}  // namespace haptic::server
