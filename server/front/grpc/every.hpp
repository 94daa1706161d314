#pragma once
/// A call that comes again and again (private to server/front/grpc).

#include <grpcpp/alarm.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

namespace haptic::server {

/// Calls `look` on gRPC's threads every `period`, counted from the end of the call before.
class Every {
 public:
  Every(std::chrono::milliseconds period, std::function<void()> look)
      : period_(period), look_(std::move(look)) {
    const std::lock_guard lock(mutex_);
    set_alarm();
  }
  /// Waits for a call that is under way; not from inside one.
  ~Every() {
    std::unique_lock lock(mutex_);
    stopping_ = true;
    alarm_->Cancel();
    idle_.wait(lock, [&] { return !waiting_; });
  }
  Every(const Every&) = delete;
  Every& operator=(const Every&) = delete;

 private:
  void set_alarm() {
    waiting_ = true;
    alarm_ = std::make_unique<grpc::Alarm>();
    alarm_->Set(std::chrono::system_clock::now() + period_, [this](bool rang) {
      if (rang) look_();
      const std::lock_guard lock(mutex_);
      if (rang && !stopping_) return set_alarm();
      waiting_ = false;
      idle_.notify_all();
    });
  }

  const std::chrono::milliseconds period_;
  const std::function<void()> look_;
  std::mutex mutex_;
  std::condition_variable idle_;
  bool stopping_{false};
  bool waiting_{false};
  std::unique_ptr<grpc::Alarm> alarm_;
};

}  // namespace haptic::server
