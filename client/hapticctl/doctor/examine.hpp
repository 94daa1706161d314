#pragma once
/// Judges whether a host is fit to run a 1 kHz loop, says what would improve it, and how stiff a
/// spring may be on it (core/METHOD.md#sampled-data). Pure: everything that it judges is an
/// argument.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "doctor/host_files.hpp"

namespace haptic::ctl {

/// Lateness of the wake-ups of a bare 1 kHz loop.
struct Jitter {
  std::uint64_t ticks{0};    ///< deadlines, skipped ones included
  std::uint64_t skipped{0};  ///< deadlines that had passed before the loop woke
  double p50_us{0.0}, p99_us{0.0}, max_us{0.0};
};

/// Answers of the kernel as errno values; 0: granted.
struct HostAnswers {
  int fifo_error{0};                       ///< when SCHED_FIFO 80 was asked for
  bool sys_nice{false};                    ///< CAP_SYS_NICE is effective
  std::optional<std::uint64_t> memlock{};  ///< RLIMIT_MEMLOCK, bytes; absent: unlimited
  bool ipc_lock{false};                    ///< CAP_IPC_LOCK is effective
  int idle_error{0};                       ///< when /dev/cpu_dma_latency was opened for writing
  /// The serial ports that this user may not open, with the group that may.
  std::map<std::string, std::string> closed_ports{};
  Jitter jitter{};
};

/// Loop and damping for which the cap is computed.
struct StiffnessQuestion {
  double period_s{1e-3};
  double device_damping{1.0};    ///< b, the device's own, N s/m or N m s/rad
  double rendered_damping{0.0};  ///< B of Z_q
};

enum class Health : std::uint8_t { kGood, kImpaired, kBad };

struct Finding {
  /// "kernel", "real-time", "memory", "idle", "cgroup", "governor", "serial" or "jitter".
  std::string what{};
  Health health{Health::kGood};
  std::string found{};
  std::string advice{};  ///< what to do; empty if there is nothing to do
};

/// Largest stiffness by core/METHOD.md#sampled-data, N/m or N m/rad.
struct StiffnessCap {
  double hold_s{0.0};   ///< the longest time that one force was held: period and largest lateness
  double delay_s{0.0};  ///< t_d: lateness (p99) and what the serial link adds
  double passive{0.0};  ///< 2 (b - B) / hold: never gives out more than the device absorbs
  double stable{0.0};  ///< (b + B) / (period / 2 + t_d): above it even a steady press may oscillate
};

struct Report {
  std::string grade{};  ///< "real-time", "degraded" or "unfit": that of the worst finding
  std::vector<Finding> findings{};
  StiffnessCap cap{};
};

[[nodiscard]] Report examine(const HostFiles& host, const HostAnswers& answers,
                             const StiffnessQuestion& question);

/// For people: a line per finding, its advice below it, the grade, the cap.
[[nodiscard]] std::string to_text(const Report& report, const StiffnessQuestion& question);
/// One JSON object.
[[nodiscard]] std::string to_json(const Report& report, const StiffnessQuestion& question);

}  // namespace haptic::ctl
