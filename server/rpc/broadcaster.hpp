#pragma once
/// From the telemetry drain to the streams of one device: the controller first, then everybody else
/// as far as the budget reaches.

#include <memory>
#include <mutex>
#include <vector>

#include "server/rpc/state_frame.hpp"
#include "server/telemetry/telemetry.hpp"

namespace haptic::server {

/// States per second that all streams of a device but its controller's may cost: a bucket that time
/// refills. One thread, the telemetry drain's.
class WatchBudget {
 public:
  explicit WatchBudget(double states_per_second) : rate_(states_per_second) {}
  void refill(core::TimePoint now) noexcept;
  /// There is one state's worth to take.
  [[nodiscard]] bool left() const noexcept { return tokens_ >= 1.0; }
  void take() noexcept { tokens_ -= 1.0; }

 private:
  double rate_;
  double tokens_{0.0};
  core::TimePoint last_{};
  bool started_{false};
};

/// A stream that receives states.
class Subscriber {
 public:
  virtual ~Subscriber() = default;
  /// Drain's thread, once per emptied ring. Sends what is due; never blocks. True where a state was
  /// sent. `states_allowed` false: everything but a state.
  virtual bool offer(const core::TickRecord& record, StateFrame& frame, bool states_allowed) = 0;
};

class Broadcaster final : public RecordListener {
 public:
  /// Listens to unit `index` for as long as it lives. `sessions`: of the same device.
  Broadcaster(Telemetry& telemetry, std::size_t index, WatchBudget budget,
              const DeviceSessions& sessions);
  ~Broadcaster() override;
  Broadcaster(const Broadcaster&) = delete;
  Broadcaster& operator=(const Broadcaster&) = delete;

  /// The stream of lease `epoch` (the loop's: Lease::grant) comes first while that lease lasts, and is one of the others when
  /// it ended; epoch 0: one of the others from the beginning. Any thread, but not from offer(). After
  /// remove() returned offer() is not called again.
  void add(std::shared_ptr<Subscriber> subscriber, std::uint32_t epoch = 0);
  void remove(const Subscriber* subscriber);

  void on_record(const core::TickRecord& record) override { static_cast<void>(record); }
  void on_newest(const core::TickRecord& record) override;

 private:
  struct Controller {
    std::uint32_t epoch{0};
    std::shared_ptr<Subscriber> stream{};
  };
  void demote_expired(const core::CommandSnapshot& command);

  Telemetry& telemetry_;
  const std::size_t index_;
  WatchBudget budget_;
  const DeviceSessions& sessions_;

  std::mutex mutex_;
  StateFrame frame_;
  std::vector<Controller> controllers_;
  std::vector<std::shared_ptr<Subscriber>> others_;
  std::size_t turn_{0};  ///< who of the others is asked first: the first that got nothing last time
};

}  // namespace haptic::server
