#pragma once
/// Sees the host (or the kernel) take processors away. A thread pinned to each processor naps again
/// and again for 1 ms, at a real-time priority above hapticd's loop and everything else of ours;
/// when it wakes late, no load of ours was the reason. Naps and notes need no memory but a table
/// that is there from the start.
///
/// The one load that could make it late is a real-time thread of ours that leaves other programs no
/// time for the better part of a second, so that the kernel holds all of them back
/// (sched_rt_runtime_us). Such a loop has missed every deadline before, and its bucket is full
/// without a stall to explain it.

#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/relay/host_excuse.hpp"

namespace haptic::test {

/// Those that this process may use.
[[nodiscard]] std::vector<int> own_processors();
/// Pins the calling thread to `processor`, at SCHED_FIFO `priority`. 0, or errno's value.
[[nodiscard]] int take_processor(int processor, int priority);

class HostWitness {
 public:
  static constexpr int kPriority = 90;  ///< SCHED_FIFO; the loop's is 80, the kernel's own 50 or 99
  static constexpr std::chrono::nanoseconds kNap{std::chrono::milliseconds(1)};
  /// Later than this is noted: what costs a loop of 1 kHz a deadline.
  static constexpr std::chrono::nanoseconds kLate{std::chrono::milliseconds(1)};
  static constexpr std::size_t kStalls = 4096;  ///< per processor; what is more is not seen

  /// On own_processors(). Returns when each is watched, or refused.
  HostWitness();
  ~HostWitness();
  HostWitness(const HostWitness&) = delete;
  HostWitness& operator=(const HostWitness&) = delete;

  /// "SCHED_FIFO 90 refused (Operation not permitted)"; empty: it has its priority everywhere.
  [[nodiscard]] std::string refusal() const;
  /// What it saw so far, each from the last sign of life before it to the next one, on a clock that
  /// shows 0 s at `origin` of CLOCK_MONOTONIC.
  [[nodiscard]] Testimony testimony(std::chrono::nanoseconds origin) const;
  /// For the table: "longest stall of the host 8 ms, 40 ms stolen", "no stall of the host", or the
  /// refusal. Stolen is what the kernel itself counts, of all processors in steps of 10 ms, where
  /// the host of a virtual machine tells it: another word on whether host or kernel it was.
  [[nodiscard]] std::string summary() const;

 private:
  struct Post;
  const double stolen_before_;  ///< s
  std::atomic<bool> running_{true};
  std::vector<std::unique_ptr<Post>> posts_{};
  std::vector<std::thread> threads_{};
};

}  // namespace haptic::test
