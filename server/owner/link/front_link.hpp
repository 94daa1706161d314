#pragma once
/// The owner's side of the front: starts fronts, passes on what they ask and replaces one that ends
/// or hangs. A front is trusted no more than the most privileged client: what it sends is copied
/// first and made harmless then (from_front.hpp), a bounded number at a time. The local control
/// socket has a thread of its own (LocalCommands), and needs no front.

#include <array>
#include <atomic>
#include <functional>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/base/core_share.hpp"
#include "server/base/wake_up.hpp"
#include "server/crossing/link_messages.hpp"
#include "server/owner/app.hpp"
#include "server/owner/link/front_process.hpp"
#include "server/owner/link/front_requests.hpp"
#include "server/owner/link/hand_over.hpp"
#include "server/owner/link/launcher.hpp"
#include "server/owner/link/publisher.hpp"
#include "server/owner/link/sample_intake.hpp"
#include "server/owner/link/turn_watch.hpp"
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
    Launcher* launcher{nullptr};            ///< null: the scene is offline, there is no front
    std::shared_ptr<HandOver> hand_over{};  ///< null only with `launcher`
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
  /// Where fronts serve.
  [[nodiscard]] std::vector<std::string> addresses() const override;

 private:
  using Stage = FrontProcess::Stage;
  using Place = std::unique_ptr<FrontProcess>;

  void run() noexcept;
  void turn();
  void wait_for_news();
  // front_link_traffic.cpp: what fronts send.
  /// Takes what it sent. False: it is to be ended, for the reason that is in `wrong_`.
  [[nodiscard]] bool hear(FrontProcess& front);
  [[nodiscard]] bool take_messages(FrontProcess& front);
  [[nodiscard]] bool take(FrontProcess& front, FrontMessage& message);
  void serves_now(FrontProcess& front);
  void publish_facts();
  // front_link.cpp: the life of fronts.
  void listen_locally();
  void restart_asked(std::uint64_t reply_to);
  void restart_for(std::uint64_t reply_to);
  void start_front();
  void notices();
  void look_after();
  void watch_launcher();
  void free_thread();
  void tell_to_go();
  /// Passes on what `act` says; false, and its words in `wrong_`, if it throws.
  template <typename Act>
  [[nodiscard]] bool try_to(const Act& act);
  [[nodiscard]] bool welcome(FrontProcess& front);
  [[nodiscard]] bool go(FrontProcess& front);
  void leave(FrontProcess& front);
  void end(FrontProcess& front, const std::string& why);
  void clear_away(Place& place);

  Owner& owner_;
  const Config config_;
  const SharedMemory front_config_;  ///< FrontConfig as bytes; a front can only read it
  std::shared_ptr<Publisher> publisher_;
  LocalCommands local_;
  const WakeUp wakes_{};  ///< the link's thread, for restarts and stop()
  SampleIntake intake_;
  FrontRequests requests_;

  // The link's thread.
  core::TimePoint now_{};
  std::vector<pollfd> wait_{};
  CoreShare share_{};  ///< whatever fronts send
  Place current_{}, next_{};
  std::uint32_t generation_{0};
  core::TimePoint start_at_{};
  core::Duration pause_{0};  ///< before the next start of a front that did not last
  core::TimePoint facts_due_{};
  std::uint64_t served_{0};
  std::string wrong_{};
  std::uint64_t restart_reply_{0};
  FrontCounters counted_{};  ///< by the fronts before
  bool told_lost_{false}, launcher_silent_{false};

  std::promise<void> first_{};
  bool first_told_{false};
  std::atomic<bool> stopping_{false}, restart_wanted_{false};
  std::atomic<std::uint64_t> restart_asked_{0};  ///< by a local user, who waits for the answer
  std::array<std::atomic<pid_t>, 2> alive_{};    ///< fronts, by generation
  TurnWatch watch_{[this] { free_thread(); }};
  std::thread thread_{};
};

}  // namespace haptic::server
