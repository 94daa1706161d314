#pragma once
/// The front without a transport: which call waits for which answer of the owner, and who hears the
/// events of a device.

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "server/crossing/outcome.hpp"
#include "server/crossing/ports.hpp"

namespace haptic::server {

/// Events on their way to one session or watch.
/// Bounded: a client that does not read loses the oldest, and the next event it gets says how many.
/// Any thread.
class EventQueue {
 public:
  static constexpr std::size_t kCapacity = 256;
  void push(const DeviceEvent& event);
  [[nodiscard]] std::optional<DeviceEvent> pop();

 private:
  mutable std::mutex mutex_;
  std::deque<DeviceEvent> events_;
  std::uint64_t dropped_untold_{0};
};

/// Posts samples, and hears of what became of each.
class SampleSource {
 public:
  virtual ~SampleSource() = default;
  /// See FrontPort::on_judged().
  virtual void on_judged(const Judged& judged) = 0;
};

class Front : public FrontPort {
 public:
  using Answered = std::function<void(const Answer&)>;

  /// `owner` must outlive this.
  explicit Front(OwnerPort& owner);

  [[nodiscard]] OwnerPort& owner() const noexcept { return owner_; }
  [[nodiscard]] const DeviceFacts& facts(std::size_t device) const {
    return owner_.devices().at(device);
  }
  /// A device by name; empty: the only one. Refused: NO_SUCH_DEVICE, or empty with several devices.
  [[nodiscard]] Outcome<std::size_t> device(const std::string& name) const;

  /// Posts `request` under an id, which is the answer. `answered` is called once, at once or later
  /// on the owner link's thread; it must not block. If no answer came `until` then, give_up()
  /// refuses the request.
  std::uint64_t ask(Request request, Answered answered,
                    core::TimePoint until = core::TimePoint::max());
  /// Posts a request that has no answer.
  void tell(const Request& request) { owner_.post(request); }
  /// Takes back every request whose time is up: NO_ANSWER.
  void give_up(core::TimePoint now);

  /// A ticket for the samples of `source`, which hears of its own as long as it lives.
  [[nodiscard]] std::uint64_t ticket(const std::weak_ptr<SampleSource>& source);
  void forget(std::uint64_t ticket);

  /// The events of a device from now on, as long as the queue lives; before them those later than
  /// `after`, as far as the last kCapacity events of all devices go back. TimePoint{}: none.
  [[nodiscard]] std::shared_ptr<EventQueue> subscribe(std::size_t device,
                                                      core::TimePoint after = {});

  void on_answer(const Answer& answer) override;
  void on_judged(const Judged& judged) override;
  void on_event(std::size_t device, const DeviceEvent& event) override;

 private:
  [[nodiscard]] Answered take(std::uint64_t id);

  OwnerPort& owner_;
  std::atomic<std::uint64_t> last_id_;
  std::mutex mutex_;
  struct Open {
    Answered answered{};
    core::TimePoint until{};
  };
  std::unordered_map<std::uint64_t, Open> open_;
  std::unordered_map<std::uint64_t, std::weak_ptr<SampleSource>> sources_;  ///< by ticket
  std::vector<std::vector<std::weak_ptr<EventQueue>>> queues_;              ///< per device
  std::deque<std::pair<std::size_t, DeviceEvent>> happened_;  ///< the last, with their devices
};

}  // namespace haptic::server
