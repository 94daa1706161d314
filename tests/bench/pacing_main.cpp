/// Ticks begun by a board's samples (loop.paced_by) against ticks by the timer: the product's loop
/// with an emulated board on a pseudo-terminal.
///
/// One block is a second of ticks, in four stretches: what a timer's tick finds depends on the
/// phase between it and the board, which is another in every stretch. A block with a fault in it
/// (the board silent for 100 ms, a tick half a second late, ...), with records lost, or paced
/// without a tick begun by a sample, ends the program with 1.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/emulator/serve.hpp"
#include "server/rt/loop.hpp"
#include "server/scene/scene.hpp"
#include "server/telemetry/telemetry.hpp"
#include "tests/bench/paired.hpp"
#include "tests/bench/percentile.hpp"

namespace {

using namespace haptic;
using bench::percentile;
using namespace std::chrono_literals;

constexpr core::Duration kPeriod = 1ms;
constexpr int kStretches = 4;
constexpr auto kStretch = 250ms;
constexpr int kSettling = 20;  ///< first ticks of a stretch, not judged: a phase is found in four
constexpr int kBlocks = 20;

std::string reasons(core::FaultSet faults) {
  std::string all;
  for (int n = 1; n < 32; ++n) {
    const auto fault = static_cast<core::Fault>(n);
    if (!faults.has(fault)) continue;
    all += (all.empty() ? "" : ", ") + std::string(core::reason(fault));
  }
  return all;
}

double ms(core::Duration d) {
  return 1e3 * core::seconds(d);
}

/// The faults of a tick, and whether the host stood still then: a tick late, or long after the
/// last.
std::string told(const core::TickRecord& record) {
  char text[160];
  std::snprintf(
      text, sizeof text,
      ": the newest sample was %.1f ms old, the tick %.1f ms late, %.1f ms after the last",
      ms(record.input.now - record.input.device.sample.time), ms(record.input.loop.lateness),
      ms(record.beat.dt));
  return reasons(record.faults()) + text;
}

/// The ticks of one block, by their records; of each stretch without the first.
class Ticks final : public server::RecordListener {
 public:
  void begin_stretch() { settling_ = kSettling; }
  void on_record(const core::TickRecord& record) override {
    ++records;
    if (record.faults().any() && fault.empty()) fault = told(record);
    if (settling_-- > 0) return;
    const core::TimePoint sampled = record.input.device.sample.time;
    lateness_us.push_back(1e6 * core::seconds(record.input.loop.lateness));
    age_us.push_back(1e6 * core::seconds(record.input.now - sampled));
    skipped += record.input.loop.skipped;
  }
  std::vector<double> lateness_us{}, age_us{};
  std::uint64_t records{0}, skipped{0};
  std::string fault{};  ///< those of the first tick with any

 private:
  int settling_{0};
};

/// An emulated board at the end of a pseudo-terminal, in a thread of its own.
class Emulator {
 public:
  Emulator()
      : board_({}, {Eigen::Vector2d::Zero(), Eigen::Vector2d(0.5, 0.5)},
               core::make_finger_exoskeleton({})),
        thread_([this] { serve(board_, terminal_, stop_); }) {}
  ~Emulator() {
    stop_ = true;
    thread_.join();
  }
  Emulator(const Emulator&) = delete;
  Emulator& operator=(const Emulator&) = delete;

  [[nodiscard]] std::string port() const { return terminal_.port().string(); }

 private:
  hw::emulator::PseudoTerminal terminal_{""};
  hw::emulator::EmulatedBoard board_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// hapticd's unit for the board at `port`.
std::unique_ptr<server::DeviceUnit> board_unit(const std::string& port) {
  // As in serial.py: a late loop is counted here, not ended by a fault; a board that is gone is
  // one.
  const server::Scene scene = server::load_scene(
      HAPTIC_SOURCE_DIR "/server/scenes/finger_board.textproto",
      {"device[0].board.port=" + port, "device[0].board.max_silence={ nanos: 100000000 }"});
  const server::DeviceScene& device = scene.devices.front();
  auto opened = hw::open_device(*device.source, device.pipeline.kinematics);
  core::PipelineConfig config = server::pipeline_config(device, opened->info().limits);
  config.loop_late_fault = 500ms;
  config.late_bucket_full = 1'000'000;
  return std::make_unique<server::DeviceUnit>(device.name, std::move(opened), config);
}

/// One way to begin ticks, and what its blocks were like beside the figures that are compared.
class Program {
 public:
  Program(server::DeviceUnit& unit, bool by_samples)
      : unit_(unit), samples_(by_samples ? unit.device().sample_signal() : nullptr) {}

  /// p50 and p99 of the sample's age when a tick uses it, p99 of the tick's lateness; us.
  std::vector<double> block() {
    Ticks ticks;
    Counts counts;
    for (int i = 0; i < kStretches; ++i) counts += stretch(ticks);
    check(ticks, counts);
    const auto of_thousand = [](std::uint64_t some, std::uint64_t all) {
      return 1e3 * static_cast<double>(some) / static_cast<double>(all);
    };
    // Both are counted while the loop runs, one after the other: one may be ahead.
    const std::uint64_t by_sample = std::min(counts.by_sample, counts.judged);
    by_timer.push_back(of_thousand(counts.judged - by_sample, counts.judged));
    skipped.push_back(of_thousand(ticks.skipped, ticks.age_us.size()));
    return {percentile(ticks.age_us, 0.5), percentile(ticks.age_us, 0.99),
            percentile(ticks.lateness_us, 0.99)};
  }

  std::vector<double> by_timer{}, skipped{};  ///< of a thousand ticks, per block

 private:
  /// Ticks: of all; of those after the settling, and of these the ones that a sample began.
  struct Counts {
    std::uint64_t all{0}, judged{0}, by_sample{0};
    void operator+=(const Counts& more) {
      all += more.all;
      judged += more.judged;
      by_sample += more.by_sample;
    }
  };

  Counts stretch(Ticks& ticks) {
    ticks.begin_stretch();
    server::Telemetry telemetry({&unit_});
    telemetry.add(0, &ticks);
    telemetry.start();
    std::this_thread::sleep_for(core::Duration(phase_(random_)));
    server::Loop loop({}, kPeriod);
    loop.begin({&unit_}, telemetry.bell(), samples_);
    std::this_thread::sleep_for(kSettling * kPeriod);
    const server::LoopStatistics settled = loop.statistics();
    std::this_thread::sleep_for(kStretch);
    loop.finish(core::Duration::zero());
    telemetry.stop();
    const server::LoopStatistics end = loop.statistics();
    return {end.ticks, end.ticks - settled.ticks, end.paced_by_sample - settled.paced_by_sample};
  }

  void check(const Ticks& ticks, const Counts& counts) const {
    if (!ticks.fault.empty()) throw std::runtime_error("a block ended in " + ticks.fault);
    if (ticks.records != counts.all || ticks.age_us.empty() || counts.judged == 0) {
      throw std::runtime_error("a block of " + std::to_string(counts.all) + " ticks left " +
                               std::to_string(ticks.records) + " records");
    }
    if (samples_ != nullptr && counts.by_sample == 0) {
      throw std::runtime_error("a block paced by the board has no tick that a sample began");
    }
  }

  server::DeviceUnit& unit_;
  hw::SampleSignal* samples_;
  std::mt19937_64 random_{1};
  std::uniform_int_distribution<std::int64_t> phase_{0, kPeriod.count() - 1};
};

void compare_with_timer() {
  const Emulator board;
  const std::unique_ptr<server::DeviceUnit> unit = board_unit(board.port());
  Program paced(*unit, true), timed(*unit, false);
  const std::vector<bench::Row> rows = bench::compare_all(
      {"age of the board's sample at its tick p50", "age of the board's sample at its tick p99",
       "loop wake lateness p99"},
      "ticks by the timer", "us", [&] { return paced.block(); }, [&] { return timed.block(); },
      kBlocks);
  bench::print_header();
  for (const bench::Row& row : rows) bench::print(row);
  const auto beside = [](const std::string& what, std::vector<double> values) {
    values.erase(values.begin());  // the warm-up
    bench::print(bench::figure(what, "of 1000 ticks", values));
  };
  beside("paced: begun by the timer", paced.by_timer);
  beside("paced: skipped", paced.skipped);
  beside("by the timer: skipped", timed.skipped);
}

}  // namespace

int main() {
  try {
    compare_with_timer();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "haptic-bench-pacing: %s\n", error.what());
    return 1;
  }
  return 0;
}
