#pragma once
/// The owner's pages: what every front reads. Answers, events, verdicts, states and totals are
/// written where they come up, by the thread on which they do, and a front is woken; the writer
/// waits for no reader.

#include <atomic>
#include <functional>
#include <mutex>
#include <unordered_set>
#include <vector>

#include "server/crossing/shared_layout.hpp"
#include "server/crossing/shared_memory.hpp"
#include "server/owner/rights/owner.hpp"

namespace haptic::server {

class Publisher final : public FrontPort {
 public:
  /// `local`: gets the answers to the owner's own requests (kLocalIds), on any thread.
  Publisher(const Owner& owner, std::function<void(const Answer&)> local);

  [[nodiscard]] const SharedMemory& memory() const noexcept { return memory_; }

  // One thread, the link's.
  void judged(const Judged& judged) noexcept { pages_.judged.publish(judged); }
  void facts(const ServerFacts& facts) noexcept { pages_.facts.publish(facts); }
  void totals(std::size_t device, const TickTotals& totals) noexcept {
    pages_.devices[device].totals.publish(totals);
  }
  void counted(const FrontCounters& counters) noexcept { pages_.counted.publish(counters); }

  /// A front's request is posted, which will be answered. False: more wait than an honest front has
  /// open (OwnerLink), or this id does.
  [[nodiscard]] bool expect_answer(std::uint64_t id);
  /// It will not be answered, as far as the owner can tell.
  void forget_answer(std::uint64_t id);
  void forget_answers();

  /// A status is written with the event that changes it, and so often: counts and the time of the
  /// newest tick come by no event.
  static constexpr core::Duration kStatusEvery{std::chrono::milliseconds(50)};
  void ring() noexcept;

  void on_answer(const Answer& answer) override;
  void on_event(std::size_t device, const DeviceEvent& event) override;
  void on_newest(std::size_t device, const SerialisedState& state) override;

 private:
  /// Any thread. The last status with its device.
  void status(std::size_t device);

  const Owner& owner_;
  const std::function<void(const Answer&)> local_;
  SharedMemory memory_;
  OwnersPages& pages_;
  struct Told {
    std::atomic<bool> changed{false};  ///< by an event since the newest status
    core::TimePoint at{};              ///< of the newest status; the drain's
  };
  std::vector<Told> told_;                    ///< per device
  std::mutex mutex_;                          ///< answers and statuses come from several threads
  std::unordered_set<std::uint64_t> open_{};  ///< requests of the front
};

}  // namespace haptic::server
