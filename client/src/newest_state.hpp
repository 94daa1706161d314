#pragma once
/// The newest state of a session, and which state the user was last given.

#include <cstdint>
#include <utility>
#include <vector>

#include "haptic/client/types.hpp"

namespace haptic::client {

class NewestState {
 public:
  /// The state that the user computes the next sample from.
  struct Given {
    std::uint64_t seq{0};
    std::chrono::steady_clock::time_point received{};
    std::vector<double> x_probe{};
  };

  /// False if a newer one is known: the other carrier was faster.
  bool take(DeviceState state) {
    if (newest_.seq != 0 && state.seq <= newest_.seq) return false;
    newest_ = std::move(state);
    called_back_ = false;
    return true;
  }
  /// Another session begins; its server may count ticks from the beginning.
  void restart() { *this = {}; }

  /// A copy for the user, who computes the next sample from it.
  [[nodiscard]] DeviceState give() {
    given_ = {newest_.seq, newest_.received, newest_.x_probe};
    return newest_;
  }
  /// True once per state, if on_state has not had the newest one yet.
  [[nodiscard]] bool to_call_back() noexcept { return !std::exchange(called_back_, true); }
  /// True if wait_for_state() has not returned the newest state yet.
  [[nodiscard]] bool to_return() const noexcept { return newest_.seq > returned_; }
  [[nodiscard]] DeviceState give_to_waiting() {
    returned_ = newest_.seq;
    return give();
  }

  [[nodiscard]] const DeviceState& newest() const noexcept { return newest_; }
  [[nodiscard]] const Given& given() const noexcept { return given_; }

 private:
  DeviceState newest_{};
  Given given_{};
  std::uint64_t returned_{0};
  bool called_back_{true};
};

}  // namespace haptic::client
