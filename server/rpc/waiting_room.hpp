#pragma once
/// Session streams whose first message has not come (private to server/rpc). The server
/// does not know yet who they are, and each costs memory: so there are few, and none stays long.

#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "haptic/core/time.hpp"

namespace haptic::server {

class OpenStream;

class WaitingRoom {
 public:
  WaitingRoom(std::size_t places, core::Duration patience) : places_(places), patience_(patience) {}

  /// `stream` waits from `now` on. If every place was taken, the stream that waited longest loses
  /// its own and is returned: streams that never open do not keep out one that opens at once.
  [[nodiscard]] std::shared_ptr<OpenStream> enter(const std::shared_ptr<OpenStream>& stream,
                                                  core::TimePoint now);
  /// Its first message came, or it ended. False if it was not waiting any more.
  [[nodiscard]] bool leave(const OpenStream& stream);
  /// Those who have waited for `patience`; they have left.
  [[nodiscard]] std::vector<std::shared_ptr<OpenStream>> overdue(core::TimePoint now);

  [[nodiscard]] std::size_t waiting() const;
  [[nodiscard]] std::size_t places() const noexcept { return places_; }
  [[nodiscard]] core::Duration patience() const noexcept { return patience_; }

 private:
  struct Guest {
    const OpenStream* name{nullptr};
    std::weak_ptr<OpenStream> stream{};
    core::TimePoint since{};
  };

  const std::size_t places_;
  const core::Duration patience_;
  mutable std::mutex mutex_;
  std::deque<Guest> guests_{};  ///< in the order in which they came
};

}  // namespace haptic::server
