#pragma once
/// One front as the owner sees it: its end of the socket, the pages that the front writes, and how
/// far it got.

#include <sys/types.h>

#include <string>
#include <vector>

#include "server/crossing/front_config.hpp"
#include "server/crossing/packet_socket.hpp"
#include "server/crossing/shared_layout.hpp"
#include "server/owner/rights/owner.hpp"

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

  void enter(Stage to, core::TimePoint now) {
    stage = to;
    since = beat_at = now;
  }
  /// Hands it `config`, which are the bytes of start.config, the owner's pages and what was opened
  /// for it. False: the front is gone.
  [[nodiscard]] bool welcome(int owners_pages, const SharedMemory& config,
                             const FrontStart& start) const;
  /// Reads the eventfd by which the front wakes the owner.
  void hear() const;
  /// Looks at its sign of life.
  void look(core::TimePoint now);

  const std::uint32_t generation;
  Descriptor link{};      ///< the owner's end
  Descriptor its_link{};  ///< the front's, until it is started
  Descriptor wakes_owner{};
  SharedMemory memory;
  FrontsPages& pages;
  pid_t pid{0};  ///< 0: not known yet
  Stage stage{Stage::kStarting};
  core::TimePoint since{};         ///< of the stage
  core::TimePoint served_since{};  ///< TimePoint{}: it never did
  core::TimePoint beat_at{};
  std::uint64_t beats{0};
  bool gone{false};                    ///< the process has ended
  bool queued{false};                  ///< more messages wait than one turn takes
  std::vector<std::uint32_t> stops{};  ///< of FrontsPages::stops, as far as they were obeyed
};

/// An eventfd. Throws core::TransportError.
[[nodiscard]] Descriptor event_descriptor();
/// Reads it, so that it waits for the next one.
void empty(const Descriptor& event);

}  // namespace haptic::server
