#include "tests/bench/patience_study.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>
#include <vector>

#include "server/rt/deadline_grid.hpp"
#include "server/rt/sample_grid.hpp"
#include "tests/bench/percentile.hpp"

namespace haptic::bench {
namespace {

using core::Duration;
using core::TimePoint;

constexpr Duration kPeriod = std::chrono::milliseconds(1);
constexpr TimePoint kStart{std::chrono::hours(1)};
constexpr double kWorstCrystalPpm = 50.0;  // of an ordinary crystal

struct Sample {
  TimePoint made{}, arrived{};
};

double us(Duration d) {
  return 1e6 * core::seconds(d);
}

/// Uniform in [0, 1), the same with every standard library.
double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1.0p-53;
}

/// In the order of their arrival, which is that of their making.
std::vector<Sample> samples(const SampleLink& link, int run, int runs, Duration length) {
  std::mt19937_64 random(static_cast<std::uint64_t>(run) + 1);
  const double step =
      core::seconds(kPeriod) * (1.0 + 1e-6 * kWorstCrystalPpm * (2.0 * uniform(random) - 1.0));
  const TimePoint first = kStart + kPeriod * run / runs;
  // One of them is before the first sample.
  const TimePoint frames = kStart - core::duration(core::seconds(link.frame) * uniform(random));
  std::vector<Sample> all;
  TimePoint last = kStart;
  for (std::int64_t k = 0; core::duration(static_cast<double>(k) * step) < length; ++k) {
    Sample sample;
    sample.made = first + core::duration(static_cast<double>(k) * step);
    const double late = -core::seconds(link.jitter) * std::log1p(-uniform(random));
    sample.arrived = sample.made + link.delay + core::duration(late);
    if (uniform(random) < link.held_up) {
      sample.arrived += core::duration(core::seconds(kPeriod) * uniform(random));
    }
    if (link.frame > Duration::zero()) {
      sample.arrived = frames + ((sample.arrived - frames) / link.frame + 1) * link.frame;
    }
    if (uniform(random) < link.lost) continue;
    last = sample.arrived = std::max(sample.arrived, last);
    all.push_back(sample);
  }
  return all;
}

struct Tick {
  TimePoint now{};
  bool by_sample{false};
};

class ByTimer {
 public:
  Tick next(std::optional<TimePoint>) {
    const TimePoint now = grid_.deadline();
    static_cast<void>(grid_.wake(now, Duration::zero()));
    return {now, false};
  }

 private:
  server::DeadlineGrid grid_{kStart + kPeriod, kPeriod};
};

class BySamples {
 public:
  explicit BySamples(Duration patience) : grid_(kStart + kPeriod, kPeriod, patience) {}

  /// `arrival`: of the next sample that no tick has read (LoopBody::next_sample).
  Tick next(std::optional<TimePoint> arrival) {
    if (arrival && *arrival > grid_.latest()) arrival.reset();
    const TimePoint now = arrival ? std::max(*arrival, grid_.earliest()) : grid_.latest();
    return {now, grid_.wake(now, Duration::zero(), arrival).by_sample};
  }

 private:
  server::SampleGrid grid_;
};

/// What the ticks of all runs of one row were like.
struct Tally {
  std::vector<double> ages_us{}, silences_us{};
  std::size_t ticks{0}, by_timer{0};
  Duration longest{0}, shortest{std::chrono::hours(1)};
};

template <typename Grid>
void run(const std::vector<Sample>& samples, Grid grid, Tally& tally) {
  std::size_t next = 0;
  TimePoint last{};
  for (;;) {
    const bool silent = next == samples.size();
    const Tick tick = grid.next(silent ? std::nullopt : std::optional(samples[next].arrived));
    const Duration gap = tick.now - last;
    if (silent) {
      tally.silences_us.push_back(us(gap));
      return;
    }
    while (next < samples.size() && samples[next].arrived <= tick.now) ++next;
    if (next > 0) {  // ticks before the first sample have nothing to use
      tally.ages_us.push_back(us(tick.now - samples[next - 1].made));
      ++tally.ticks;
      tally.by_timer += tick.by_sample ? 0 : 1;
    }
    if (tally.ticks > 0 && last != TimePoint{}) {
      tally.longest = std::max(tally.longest, gap);
      tally.shortest = std::min(tally.shortest, gap);
    }
    last = tick.now;
  }
}

}  // namespace

std::vector<SampleLink> usual_links() {
  using namespace std::chrono_literals;
  return {{"prompt: 60 us and 20 us of jitter; 1 of 1000 held up", 60us, 20us, 0us, 0.0, 1e-3},
          {"the same and 2 % lost", 60us, 20us, 0us, 0.02, 1e-3},
          {"in frames of 1 ms (USB full speed)", 60us, 20us, 1ms, 0.0, 1e-3},
          {"150 us of jitter", 60us, 150us, 0us, 0.0, 1e-3},
          {"in pairs every 2 ms (500 Hz)", 60us, 20us, 2ms, 0.0, 1e-3}};
}

PatienceRow study_patience(const SampleLink& link, std::optional<Duration> patience, int runs,
                           Duration length) {
  Tally tally;
  for (int i = 0; i < runs; ++i) {
    const std::vector<Sample> sent = samples(link, i, runs, length);
    if (patience) {
      run(sent, BySamples(*patience), tally);
    } else {
      run(sent, ByTimer(), tally);
    }
  }
  PatienceRow row;
  row.age_p50_us = percentile(tally.ages_us, 0.5);
  row.age_p99_us = percentile(tally.ages_us, 0.99);
  row.by_timer_percent =
      100.0 * static_cast<double>(tally.by_timer) / static_cast<double>(tally.ticks);
  row.longest_gap_us = us(tally.longest);
  row.shortest_gap_us = us(tally.shortest);
  row.gap_at_silence_us = percentile(tally.silences_us, 0.5);
  return row;
}

}  // namespace haptic::bench
