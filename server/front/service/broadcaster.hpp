#pragma once
/// From the owner link to the streams of one device: the controller first, then all others as
/// far as the budget reaches.

#include <memory>
#include <mutex>
#include <vector>

#include "server/crossing/ports.hpp"
#include "server/front/service/state_frame.hpp"

namespace haptic::server {

/// States per second that all streams of a device but its controller's may cost: a bucket that time
/// refills. One thread, the owner link's.
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
  /// On the owner link's thread, once per new state. Sends what is due and never blocks. True if a
  /// state was sent. `states_allowed` false: everything but a state.
  virtual bool offer(const SerialisedState& state, StateFrame& frame, bool states_allowed) = 0;
  /// On the same thread: its lease has ended, and it is one of the others now.
  virtual void lease_over() {}
};

class Broadcaster final : public FrontPort {
 public:
  Broadcaster(std::size_t device, WatchBudget budget) : device_(device), budget_(budget) {}

  /// The stream of lease `tenure` comes first while that lease lasts, and is one of the others when
  /// it has ended; 0: one of the others from the beginning. Any thread, but not from offer(). After
  /// remove() has returned offer() is not called again.
  void add(std::shared_ptr<Subscriber> subscriber, std::uint32_t tenure = 0);
  void remove(const Subscriber* subscriber);

  void on_newest(std::size_t device, const SerialisedState& state) override;

 private:
  void send(const SerialisedState& state);
  struct Entry {
    std::uint32_t tenure{0};  ///< of the lease that it controls; 0: none, or it is over
    std::shared_ptr<Subscriber> stream{};
  };

  const std::size_t device_;
  WatchBudget budget_;

  std::mutex mutex_;
  std::vector<Entry> entries_;
  std::vector<std::shared_ptr<Subscriber>> over_;  ///< whose lease ended with this state
  std::vector<Subscriber*> others_;                ///< without a lease; filled by each on_newest()
  std::size_t turn_{0};  ///< which of them is asked first: the first that got nothing last time
};

}  // namespace haptic::server
