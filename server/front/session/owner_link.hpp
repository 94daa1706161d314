#pragma once
/// The front's side of the owner: an OwnerPort over the owner's pages and two sockets.

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <unordered_set>
#include <vector>

#include "server/crossing/front_config.hpp"
#include "server/crossing/link_messages.hpp"
#include "server/crossing/packet_socket.hpp"
#include "server/crossing/ports.hpp"
#include "server/crossing/shared_layout.hpp"
#include "server/crossing/shared_memory.hpp"
#include "server/front/session/sample_sender.hpp"

namespace haptic::server {

class OwnerLink final : public OwnerPort {
 public:
  explicit OwnerLink(Descriptor link) : link_(std::move(link)) {}
  ~OwnerLink() override;

  /// Once, before all else: says hello and waits for the welcome, which brings no sockets yet.
  /// Throws core::TransportError if there is none, or if it does not hold together.
  [[nodiscard]] FrontStart hello();

  /// False: the owner does not take it.
  bool say(const FrontMessage& message);
  /// Until the owner says Go: the sockets to serve on. None: it said Leave, or is gone. Throws
  /// core::TransportError if they are not as many as the configuration says.
  [[nodiscard]] std::optional<std::vector<Descriptor>> wait_for_go();
  /// Answers, verdicts, events and states are passed on from now on, on a thread of its own.
  void begin();
  /// Returns when the owner says Leave, or is gone. From then on the owner itself knows that every
  /// stream ends: it is not told of each.
  void wait_for_leave();
  /// Ends the thread. Idempotent.
  void stop();

  [[nodiscard]] ServerFacts facts() const { return pages_->facts.value(); }
  [[nodiscard]] TickTotals totals(std::size_t device) const {
    return pages_->devices.at(device).totals.value();
  }
  /// Says what this front has counted so far; the answer is that and what those before it did.
  [[nodiscard]] FrontCounters count(const FrontCounters& own);

  [[nodiscard]] const std::vector<DeviceFacts>& devices() const noexcept override {
    return devices_;
  }
  void post(const Request& request) override;
  void post(const ProxySample& sample) override { samples_->send(sample); }
  void post(const PoseSample& pose) override { samples_->send(pose); }
  [[nodiscard]] DeviceStatus status(std::size_t device) const override;

 private:
  void take_pages(std::vector<Descriptor>& descriptors, const FrontConfig& config);
  /// The owner's next message and what it brings; kLeave if it is gone.
  [[nodiscard]] OwnerMessage hear(std::vector<Descriptor>& brought);
  [[nodiscard]] bool may_open(const Request& request);
  void refuse(const Request& request, const Refusal& why);
  void run() noexcept;
  void beat();
  void pass_on();

  Descriptor link_;
  std::uint32_t generation_{0};
  std::size_t sockets_{0};  ///< that Go must bring
  SharedMemory owners_{};
  const OwnersPages* pages_{nullptr};
  std::unique_ptr<SampleSender> samples_{};
  std::vector<DeviceFacts> devices_{};
  std::atomic<bool> leaving_{false};

  std::mutex mutex_;
  std::unordered_set<std::uint64_t> open_{};  ///< requests that wait for an answer
  FrontCounters own_{};                       ///< as count() was told

  // The thread's.
  Broadcast<Answer, 512>::Cursor answers_{};
  Broadcast<Happened, 512>::Cursor events_{};
  Broadcast<Judged, 2048>::Cursor judged_{};
  core::TimePoint beat_due_{};
  std::vector<std::uint64_t> seen_{};  ///< of each device's states
  SerialisedState newest_{};

  std::atomic<bool> stopping_{false};
  std::thread thread_{};
};

}  // namespace haptic::server
