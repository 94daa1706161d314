#pragma once
/// The owner's side of the front: starts fronts, passes on what they ask and replaces one that ends
/// or hangs. A front is trusted no more than the most privileged client: what it sends is copied
/// first and made harmless then (from_front.hpp), a bounded number at a time. The local control
/// socket has a thread of its own (LocalCommands), and needs no front.

#include <atomic>
#include <functional>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/crossing/link_messages.hpp"
#include "server/owner/app.hpp"
#include "server/owner/link/front_process.hpp"
#include "server/owner/link/front_requests.hpp"
#include "server/owner/link/hand_over.hpp"
#include "server/owner/link/launcher.hpp"
#include "server/owner/link/publisher.hpp"
#include "server/owner/link/sample_intake.hpp"
#include "server/owner/local/local_commands.hpp"
#include "server/owner/telemetry/tick_metrics.hpp"

namespace haptic::server {

class FrontLink final : public FrontRunner {
 public:
  /// A front that gave no sign of life this long is replaced.
  static constexpr core::Duration kSilence{std::chrono::seconds(2)};
  /// A front has this long for each step from its start until it serves.
  static constexpr core::Duration kStarting{std::chrono::seconds(10)};
  /// And this long to end after it was told to leave.
  static constexpr core::Duration kLeaving{std::chrono::milliseconds(1500)};

  struct Config {
    Launcher* launcher{nullptr};                  ///< null: the scene is offline, there is no front
    std::shared_ptr<const HandOver> hand_over{};  ///< null only with `launcher`
    std::string name{};  ///< of the scene; its control socket has it if it is offline
    std::function<ServerFacts()> facts{};  ///< called ten times a second, on the link's thread
    std::shared_ptr<const TickMetrics> ticks{};  ///< null: the scene has no metrics
    /// The thread of the link gets SCHED_FIFO at the lowest priority: neither a sample nor a stop
    /// waits for ordinary programs.
    bool realtime{false};
    std::function<void()> lost{};  ///< no front can be started any more: the launcher is gone
  };

  /// `owner` must outlive this.
  FrontLink(Owner& owner, Config config);
  /// stop().
  ~FrontLink() override;
  FrontLink(const FrontLink&) = delete;
  FrontLink& operator=(const FrontLink&) = delete;

  /// Returns when the first front serves and the control socket is there, which is named after the
  /// first address. Throws core::TransportError with the front's reason.
  void start() override;
  /// Ends the front, its streams first, then the thread. Idempotent.
  void stop() override;
  /// Replaces the front, as `hapticctl restart-front` does. Any thread.
  void restart() override;
  /// The loop's thread, just before each tick (SampleIntake).
  void before_tick() noexcept override { intake_.take_for_tick(); }
  /// Where fronts serve.
  [[nodiscard]] std::vector<std::string> addresses() const override;

 private:
  using Stage = FrontProcess::Stage;
  using Place = std::unique_ptr<FrontProcess>;

  void run() noexcept;
  void turn();
  void keep_within_budget();
  void wait_for_news();
  // front_link_traffic.cpp: what fronts send.
  /// False: the front is to be ended, for the reason it left in `wrong_`.
  [[nodiscard]] bool take_messages(FrontProcess& front);
  [[nodiscard]] bool take(FrontProcess& front, FrontMessage& message);
  void choose_samples();
  void serves_now(FrontProcess& front);
  void publish_facts();
  // front_link.cpp: the life of fronts.
  void listen_locally();
  void restart_asked(std::uint64_t reply_to);
  void restart_for(std::uint64_t reply_to);
  void start_front();
  void notices();
  void look_after();
  void tell_to_go();
  [[nodiscard]] bool welcome(FrontProcess& front);
  void leave(FrontProcess& front);
  void end(FrontProcess& front, const std::string& why);
  void clear_away(Place& place);

  Owner& owner_;
  const Config config_;
  const SharedMemory front_config_;  ///< FrontConfig as bytes; a front can only read it
  std::shared_ptr<Publisher> publisher_;
  LocalCommands local_;
  Descriptor wakes_;  ///< the link's thread, for restarts and stop()
  SampleIntake intake_;
  FrontRequests requests_;

  // The link's thread.
  core::TimePoint now_{};
  std::vector<pollfd> wait_{};
  core::TimePoint window_{};  ///< began then
  core::Duration busy_{0};    ///< of the window
  Place current_{}, next_{};
  std::uint32_t generation_{0};
  core::TimePoint start_at_{};
  core::Duration pause_{0};  ///< before the next start of a front that did not last
  core::TimePoint facts_due_{};
  std::uint64_t served_{0};
  std::string wrong_{};
  std::uint64_t restart_reply_{0};
  FrontCounters counted_{};  ///< by the fronts before
  bool told_lost_{false};

  std::promise<void> first_{};
  bool first_told_{false};
  std::atomic<bool> stopping_{false}, restart_wanted_{false};
  std::atomic<std::uint64_t> restart_asked_{0};  ///< by a local user, who waits for the answer
  std::thread thread_{};
};

}  // namespace haptic::server
