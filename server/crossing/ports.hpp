#pragma once
/// The two sides of the crossing as calls that carry the values of crossing.hpp. hapticd's halves
/// are two processes, which pass the same values through memory and sockets (FrontLink,
/// OwnerLink); a test program may join an owner and a front in one process.

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/crossing/crossing.hpp"
#include "server/crossing/front_config.hpp"

namespace haptic::server {

/// A front, as the owner calls it. Nothing here may block.
class FrontPort {
 public:
  virtual ~FrontPort() = default;
  /// Once per request, to every front: the id says whose it is. No lock is held; on the thread that
  /// posted the request, or the telemetry drain's.
  virtual void on_answer(const Answer& answer) { static_cast<void>(answer); }
  /// Once per sample that was posted, to every front: the ticket says whose it is. See on_answer().
  virtual void on_judged(const Judged& judged) { static_cast<void>(judged); }
  /// In the order in which things happened. Under the owner's lock: only stores the event.
  virtual void on_event(std::size_t device, const DeviceEvent& event) {
    static_cast<void>(device), static_cast<void>(event);
  }
  /// The state of the newest tick, on the telemetry drain's thread when it has emptied the ring.
  virtual void on_newest(std::size_t device, const SerialisedState& state) {
    static_cast<void>(device), static_cast<void>(state);
  }
};

/// The owner of the devices, as a front calls it. Any thread; no call waits for the loop.
class OwnerPort {
 public:
  virtual ~OwnerPort() = default;
  [[nodiscard]] virtual const std::vector<DeviceFacts>& devices() const noexcept = 0;
  /// Answers, events and states go to `front` as well, as long as it lives.
  void connect(std::weak_ptr<FrontPort> front) {
    const std::lock_guard lock(fronts_mutex_);
    fronts_.push_back(std::move(front));
  }
  /// The answer comes by FrontPort::on_answer: at once, or after the tick that gives it.
  virtual void post(const Request& request) = 0;
  /// The verdict comes by FrontPort::on_judged, in this call or later.
  virtual void post(const ProxySample& sample) = 0;
  virtual void post(const PoseSample& pose) = 0;
  [[nodiscard]] virtual DeviceStatus status(std::size_t device) const = 0;

 protected:
  using Fronts = std::vector<std::shared_ptr<FrontPort>>;
  /// Those that live.
  [[nodiscard]] Fronts fronts() {
    Fronts alive;
    const std::lock_guard lock(fronts_mutex_);
    for (const auto& weak : fronts_) {
      if (auto front = weak.lock()) alive.push_back(std::move(front));
    }
    return alive;
  }

 private:
  std::mutex fronts_mutex_;
  std::vector<std::weak_ptr<FrontPort>> fronts_{};
};

}  // namespace haptic::server
