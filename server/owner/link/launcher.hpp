#pragma once
/// A process of its own that makes fronts. It is forked before the daemon has threads, devices or
/// locked memory: to fork the owner itself would stop its loop for milliseconds while its pages are
/// marked.

#include <sys/types.h>

#include <csignal>
#include <filesystem>
#include <optional>

#include "haptic/core/time.hpp"
#include "server/crossing/packet_socket.hpp"

namespace haptic::server {

/// Limits of a front from its first instruction on, whatever its program is.
struct FrontLimits {
  std::size_t memory_bytes{0};    ///< RLIMIT_DATA, which counts whole stacks; 0: none
  std::size_t stack_bytes{0};     ///< RLIMIT_STACK, of every thread; 0: as it is
  int nice{0};                    ///< added
  std::optional<int> loop_cpu{};  ///< a core that the front keeps off
};

class Launcher {
 public:
  struct Notice {
    enum class Kind : std::uint8_t { kStarted, kEnded, kHere };
    Kind kind{Kind::kStarted};
    pid_t pid{0};   ///< 0: no process could be made
    int status{0};  ///< kEnded: as waitpid() gives it, or the error of fork()
    /// How it ended, behind the program's name.
    [[nodiscard]] std::string words() const;
  };

  /// Forks. The caller must still be the only thread. `program` is looked up at each start, so that
  /// an upgraded one is found. Throws core::TransportError.
  Launcher(std::filesystem::path program, FrontLimits limits);
  /// Ends the launcher, and with it every front.
  ~Launcher();
  Launcher(const Launcher&) = delete;
  Launcher& operator=(const Launcher&) = delete;

  /// Starts a front that has `link` as its descriptor 3, `log` as its standard output and error,
  /// and nothing to read. The launcher's answer comes by next().
  void start(Descriptor link, Descriptor log);
  /// SIGKILL to a front.
  void kill(pid_t front);
  /// Readable when next() has something to say.
  [[nodiscard]] int descriptor() const noexcept { return socket_.get(); }
  /// The fate of a front; absent: nothing more. Every started one ends once.
  [[nodiscard]] std::optional<Notice> next();
  /// The launcher has ended, which only a signal can do; next() found out.
  [[nodiscard]] bool gone() const noexcept { return gone_; }
  /// Asks it, now and then, whether it works. True: it did not answer for kPatience.
  [[nodiscard]] bool is_silent(core::TimePoint now);
  static constexpr core::Duration kPatience{std::chrono::seconds(2)};
  /// Ends it at once, and with it every front.
  void end() { ::kill(pid_, SIGKILL); }
  [[nodiscard]] pid_t pid() const noexcept { return pid_; }

 private:
  Descriptor socket_{};
  pid_t pid_{0};
  bool gone_{false};
  core::TimePoint asked_{};  ///< whether it works
  bool answered_{true};
};

}  // namespace haptic::server
