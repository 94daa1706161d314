#include "tests/relay/host_excuse.hpp"

#include <algorithm>
#include <cstdio>
#include <set>
#include <sstream>

namespace haptic::test {
namespace {

constexpr double kPeriod = 0.001;    // s, of the daemon's loop
constexpr double kLoopLate = 0.008;  // s, proto/README.md#states-of-a-device: where SCHED_FIFO was
                                     // granted
/// proto/README.md#states-of-a-device again, in words of our own: the server's bucket is among what
/// is judged.
constexpr double kPerSkipped = 5.0, kFull = 100.0;
constexpr int kGoodTicksPerDrop = 20;
constexpr double kSkippedAtMost = 0.005;  // of the ticks

class Bucket {
 public:
  void tick(double skipped) {
    if (skipped > 0.0) {
      level_ = std::min(kFull, level_ + kPerSkipped * skipped);
      good_ = 0;
    } else if (++good_ == kGoodTicksPerDrop) {
      level_ = std::max(0.0, level_ - 1.0);
      good_ = 0;
    }
  }
  [[nodiscard]] double level() const { return level_; }

 private:
  double level_{0.0};
  int good_{0};
};

/// The processors' stalls as one list that does not overlap: which held the loop nobody knows.
std::vector<Stall> merged(std::vector<Stall> stalls) {
  std::sort(stalls.begin(), stalls.end(),
            [](const Stall& a, const Stall& b) { return a.from < b.from; });
  std::vector<Stall> apart;
  for (const Stall& stall : stalls) {
    if (!apart.empty() && stall.from <= apart.back().to) {
      apart.back().to = std::max(apart.back().to, stall.to);
    } else {
      apart.push_back(stall);
    }
  }
  return apart;
}

/// s of the time from the tick's deadline to its wake-up in which a processor was away.
double stalled(const RecordedTick& tick, const std::vector<Stall>& stalls) {
  double sum = 0.0;
  for (const Stall& stall : stalls) {
    const double from = std::max(stall.from, tick.time - tick.lateness);
    sum += std::max(0.0, std::min(stall.to, tick.time) - from);
  }
  return sum;
}

std::set<std::string> reasons(const std::string& faults) {
  std::set<std::string> set;
  std::istringstream stream(faults);
  for (std::string reason; std::getline(stream, reason, '|');) set.insert(reason);
  return set;
}

std::string told(double stalled_for, int times, double at) {
  char text[80];
  if (times > 1) {
    std::snprintf(text, sizeof text, "host stalled %.0f ms, %d times, by %.1f s", 1e3 * stalled_for,
                  times, at);
  } else {
    std::snprintf(text, sizeof text, "host stalled %.0f ms at %.1f s", 1e3 * stalled_for, at);
  }
  return text;
}

/// Follows a run tick by tick: which of its lateness is the host's.
class Blame {
 public:
  explicit Blame(std::vector<Stall> stalls) : stalls_(std::move(stalls)) {}

  void tick(const RecordedTick& tick) {
    now_ = tick;
    stalled_now_ = stalled(tick, stalls_);
    hosts_ = tick.lateness >= kPeriod && tick.lateness - stalled_now_ < kPeriod;
    all_.tick(tick.skipped);
    ours_.tick(hosts_ ? 0.0 : tick.skipped);
    if (all_.level() == 0.0) {
      times_ = 0;
      stalled_since_ = 0.0;
    }
    times_ += hosts_ ? 1 : 0;
    stalled_since_ += hosts_ ? stalled_now_ : 0.0;
  }

  /// But for the host this tick would have missed no deadline.
  [[nodiscard]] bool hosts() const { return hosts_; }
  /// That `fault` was latched in this tick.
  [[nodiscard]] std::optional<std::string> excuse(const std::string& fault) const {
    if (fault == "LOOP_LATE" && now_.lateness > kLoopLate && hosts_) {
      return told(stalled_now_, 1, now_.time);
    }
    if (fault == "LATE_BUCKET_FULL" && all_.level() >= kFull && ours_.level() < kFull / 2) {
      return told(stalled_since_, times_, now_.time);
    }
    return {};
  }

 private:
  const std::vector<Stall> stalls_;
  RecordedTick now_{};
  double stalled_now_{0.0};
  bool hosts_{false};
  Bucket all_{}, ours_{};
  int times_{0};  ///< since the bucket was empty: ticks that the host made late, and by how much
  double stalled_since_{0.0};
};

}  // namespace

std::optional<std::string> host_excuse(const std::vector<RecordedTick>& run,
                                       const Testimony& testimony,
                                       const std::vector<Finding>& findings) {
  if (!testimony.above_all) return {};
  Blame blame(merged(testimony.stalls));
  std::set<std::string> latched;
  std::optional<std::string> excuse;
  double first = 0.0;
  for (const RecordedTick& tick : run) {
    blame.tick(tick);
    const std::set<std::string> faults = reasons(tick.faults);
    for (const std::string& fault : faults) {
      if (latched.count(fault) > 0) continue;
      const std::optional<std::string> this_one = blame.excuse(fault);
      if (!this_one) return {};
      if (excuse) continue;
      excuse = this_one;
      first = tick.time;
    }
    latched = faults;
  }
  const bool all_its_consequences =
      std::all_of(findings.begin(), findings.end(),
                  [&](const Finding& f) { return !f.is_final && f.at && *f.at >= first; });
  return all_its_consequences ? excuse : std::nullopt;
}

std::optional<std::string> too_many_skipped(const std::vector<RecordedTick>& run,
                                            const Testimony& testimony) {
  Blame blame(testimony.above_all ? merged(testimony.stalls) : std::vector<Stall>{});
  double ours = 0.0;
  for (const RecordedTick& tick : run) {
    blame.tick(tick);
    ours += blame.hosts() ? 0.0 : tick.skipped;
  }
  if (ours <= kSkippedAtMost * static_cast<double>(run.size())) return {};
  char text[100];
  std::snprintf(text, sizeof text, "%.0f of %zu deadlines skipped without a stall of the host",
                ours, run.size());
  return text;
}

RowReport until_a_run_counts(const std::function<RunReport()>& run) {
  RowReport row;
  std::vector<std::string> excused;
  for (int number = 1; number <= kRunsAtMost; ++number) {
    const RunReport report = run();
    const std::string name = "run " + std::to_string(number);
    if (report.excuse) {
      excused.push_back(name + ": " + *report.excuse);
      continue;
    }
    row.got = report.got;
    for (const Finding& finding : report.findings) row.failures.push_back(finding.text());
    row.got.insert(row.got.end(), row.failures.begin(), row.failures.end());
    row.got.push_back(name + ", " + report.witness);
    row.got.insert(row.got.end(), excused.begin(), excused.end());
    return row;
  }
  row.failures = {"host: none of " + std::to_string(kRunsAtMost) + " runs was undisturbed"};
  row.got = row.failures;
  row.got.insert(row.got.end(), excused.begin(), excused.end());
  return row;
}

}  // namespace haptic::test
