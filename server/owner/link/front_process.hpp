#pragma once
/// One front as the owner sees it: the owner's ends of their sockets, and how far the front got.

#include <sys/types.h>

#include <map>
#include <utility>

#include "server/crossing/front_config.hpp"
#include "server/crossing/link_messages.hpp"
#include "server/crossing/shared_memory.hpp"
#include "server/owner/link/front_log.hpp"

namespace haptic::server {

struct FrontProcess {
  enum class Stage : std::uint8_t {
    kStarting,   ///< until its hello
    kPreparing,  ///< until it is ready
    kReady,      ///< the front before it has to leave first
    kOpening,    ///< until it serves
    kServing,
    kLeaving,
    kKilled,
  };

  /// Throws core::TransportError.
  FrontProcess(std::uint32_t generation, core::TimePoint now);
  ~FrontProcess();
  FrontProcess(const FrontProcess&) = delete;
  FrontProcess& operator=(const FrontProcess&) = delete;

  void enter(Stage to, core::TimePoint now) {
    stage = to;
    since = beat_at = now;
  }
  /// Hands it the bytes of its configuration, the owner's pages and the files that were opened for
  /// it. False: the front is gone.
  [[nodiscard]] bool welcome(const SharedMemory& owners_pages, const SharedMemory& config,
                             const std::vector<Descriptor>& files);
  /// Hands it the sockets: it is to serve.
  [[nodiscard]] bool go(const std::vector<Descriptor>& sockets) const;
  /// The owner obeys it: it serves, or ends its streams.
  [[nodiscard]] bool is_heard() const noexcept {
    return stage == Stage::kServing || stage == Stage::kLeaving;
  }

  const std::uint32_t generation;
  Descriptor link{}, samples{};                     ///< the owner's ends
  Descriptor its_link{}, its_samples{}, its_log{};  ///< the front's, until it has them
  FrontLog log;
  pid_t pid{0};  ///< 0: not known yet
  Stage stage{Stage::kStarting};
  core::TimePoint since{};         ///< of the stage
  core::TimePoint served_since{};  ///< TimePoint{}: it never did
  core::TimePoint beat_at{};       ///< its newest sign of life
  FrontCounters counters{};
  bool gone{false};                            ///< the process has ended
  std::map<std::uint32_t, Text<200>> stops{};  ///< to be obeyed: device and why

 private:
  FrontProcess(std::uint32_t its_generation, core::TimePoint now,
               std::pair<Descriptor, Descriptor> log_ends);
};

}  // namespace haptic::server
