#pragma once
/// The commands of the local control socket as requests to the owner, on a thread of its own: no
/// front, and nothing that a front can touch, keeps a stop from being heard.

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "server/base/line_rate.hpp"
#include "server/owner/local/control_socket.hpp"
#include "server/owner/local/local_health.hpp"
#include "server/owner/rights/owner.hpp"

namespace haptic::server {

class LocalCommands {
 public:
  /// Another front is wanted: this thread, which must not wait. Answered by answer().
  using RestartFront = std::function<void(std::uint64_t reply_to)>;

  struct Config {
    ControlPlaces places{};
    std::vector<std::string> addresses{};  ///< for people
    bool realtime{false};                  ///< SCHED_FIFO at the lowest priority
    pid_t launcher{0};  ///< no process of its session may ask, and fronts are that; 0: none
  };

  /// `owner` must outlive this.
  LocalCommands(Owner& owner, RestartFront restart_front);
  /// stop().
  ~LocalCommands();
  LocalCommands(const LocalCommands&) = delete;
  LocalCommands& operator=(const LocalCommands&) = delete;

  /// Once: the socket is there when it returns. Throws core::TransportError.
  void listen(Config config);
  /// Ends the thread. Idempotent.
  void stop();

  // Any thread.
  /// The answer to restart_front; 0: nobody asked.
  void answer(std::uint64_t reply_to, const std::string& text);
  /// An answer to one of its requests.
  void on_answer(const Answer& answer);
  /// The answer to health tells this of the front.
  void front(const FrontView& view);

 private:
  /// A command that waits for the answers of `open` devices.
  struct Open {
    std::uint64_t reply_to{0};
    std::size_t open{0};
    std::string text{"ok"};
    bool refused{false};
    bool clear{false};
  };
  struct Asked {
    std::shared_ptr<Open> open{};
    std::size_t device{0};
  };
  void run(bool realtime) noexcept;
  void turn();
  void give_answers();
  void wake();
  void command(const ControlCommand& command);
  void ask(const ControlCommand& command, const std::vector<std::size_t>& devices);
  void tell_stop(const ControlCommand& command, const std::string& who);

  Owner& owner_;
  const RestartFront restart_front_;
  Descriptor wakes_;
  std::atomic<bool> stopping_{false};

  std::mutex mutex_;
  FrontView front_{};
  std::vector<Answer> answers_{};
  std::vector<std::pair<std::uint64_t, std::string>> texts_{};

  // The thread's.
  std::unique_ptr<ControlSocket> control_{};
  std::unique_ptr<LocalHealth> health_{};
  core::TimePoint now_{};
  std::vector<pollfd> wait_{};
  std::uint64_t last_id_{0};
  std::unordered_map<std::uint64_t, Asked> asked_{};
  std::array<LineRate, 2> lines_{};  ///< of stops: of other users, of trusted ones
  std::thread thread_{};
};

}  // namespace haptic::server
