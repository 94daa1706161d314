#pragma once
/// Periodic callback on gRPC's threads (private to server/rpc).

#include <grpcpp/alarm.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>

namespace haptic::server {

/// Calls `look` every `period`, counted from the end of the call before.
class Every {
 public:
  Every(std::chrono::milliseconds period, std::function<void()> look);
  /// Waits for a call that is under way; not from inside one.
  ~Every();
  Every(const Every&) = delete;
  Every& operator=(const Every&) = delete;

 private:
  void set_alarm();

  const std::chrono::milliseconds period_;
  const std::function<void()> look_;
  std::mutex mutex_;
  std::condition_variable idle_;
  bool stopping_{false};
  bool waiting_{false};
  std::unique_ptr<grpc::Alarm> alarm_;
};

}  // namespace haptic::server
