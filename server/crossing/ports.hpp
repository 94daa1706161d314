#pragma once
/// The two sides of the crossing as one process joins them: calls that carry the values of
/// crossing.hpp. Between two processes the same values go through shared memory.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic/core/tick/pipeline.hpp"
#include "hw/device.hpp"
#include "server/crossing/crossing.hpp"

namespace haptic::server {

/// What never changes while the server runs; the pointers outlive both sides.
struct DeviceFacts {
  std::string name{};
  const hw::DeviceInfo* info{nullptr};
  const core::PipelineConfig* config{nullptr};
  core::Duration lease_timeout{};
  /// Softness of the coupling metric that states carry (core/METHOD.md#anisotropic-coupling);
  /// absent: they carry none.
  std::optional<double> coupling_softness{};
};

/// A front, as the owner calls it. Nothing here may block.
class FrontPort {
 public:
  virtual ~FrontPort() = default;
  /// Once per request, to every front: the id says whose it is. No lock is held; on the thread that
  /// posted the request, or the telemetry drain's.
  virtual void on_answer(const Answer& answer) { static_cast<void>(answer); }
  /// In the order in which things happened. Under the owner's lock: only stores the event.
  virtual void on_event(std::size_t device, const DeviceEvent& event) {
    static_cast<void>(device), static_cast<void>(event);
  }
  /// Every tick, in order, on the telemetry drain's thread.
  virtual void on_tick(std::size_t device, const StateRecord& state) {
    static_cast<void>(device), static_cast<void>(state);
  }
  /// The newest of them again, when the drain has emptied the ring.
  virtual void on_newest(std::size_t device, const StateRecord& state) {
    static_cast<void>(device), static_cast<void>(state);
  }
};

/// The owner of the devices, as a front calls it. Any thread; no call waits for the loop.
class OwnerPort {
 public:
  virtual ~OwnerPort() = default;
  [[nodiscard]] virtual const std::vector<DeviceFacts>& devices() const noexcept = 0;
  /// Answers, events and states go to `front` as well, as long as it lives.
  virtual void connect(std::weak_ptr<FrontPort> front) = 0;
  /// The answer comes by FrontPort::on_answer: at once, or after the tick that gives it.
  virtual void post(const Request& request) = 0;
  [[nodiscard]] virtual Verdict accept(const ProxySample& sample) = 0;
  [[nodiscard]] virtual Verdict accept(const PoseSample& pose) = 0;
  [[nodiscard]] virtual DeviceStatus status(std::size_t device) const = 0;
};

}  // namespace haptic::server
