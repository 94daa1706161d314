/// haptic-bench-loop: how late the product's loop wakes, against a bare clock_nanosleep loop with
/// the same settings, idle and with two busy threads; and what the ticks of three devices cost,
/// against three times that of one. One block is 500 ticks of each.
#include <atomic>
#include <cstdio>
#include <exception>
#include <thread>
#include <vector>

#include "server/owner/loop/loop.hpp"
#include "server/owner/scene/scene.hpp"
#include "server/owner/telemetry/telemetry.hpp"
#include "tests/bench/bare_loop.hpp"
#include "tests/bench/paired.hpp"
#include "tests/bench/pressing_units.hpp"
#include "tests/support/percentile.hpp"

namespace {

using namespace haptic;
using std::chrono::milliseconds;
using test::percentile;

constexpr int kTicks = 500;
constexpr milliseconds kPeriod{1};

class Lateness final : public server::RecordListener {
 public:
  void on_record(const core::TickRecord& record) override {
    us.push_back(core::seconds(record.input.loop.lateness) * 1e6);
  }
  std::vector<double> us{};
};

/// Lateness of `kTicks` ticks of the product's loop with one finger, in us.
std::vector<double> product(const server::Scene& scene) {
  const server::DeviceScene& device = scene.devices.front();
  auto opened = device.source->open(device.pipeline.kinematics, {});
  const core::PipelineConfig config = server::pipeline_config(device, opened->info().limits);
  server::DeviceUnit unit(device.name, std::move(opened), config);
  server::Telemetry telemetry({&unit});
  Lateness lateness;
  telemetry.add(0, &lateness);
  telemetry.start();
  {
    server::Loop loop({}, kPeriod);
    loop.begin({&unit}, telemetry.bell());
    std::this_thread::sleep_for(kPeriod * kTicks);
    loop.finish(core::Duration::zero());
  }
  telemetry.stop();
  return lateness.us;
}

std::vector<double> bare() {
  std::vector<double> us;
  us.reserve(kTicks);
  std::thread thread([&us] {
    bench::bare_loop([&us](double late_us, std::int64_t) {
      us.push_back(late_us);
      return us.size() < kTicks;
    });
  });
  thread.join();
  return us;
}

void rows(const server::Scene& scene, const std::string& under) {
  for (const double p : {0.5, 0.99}) {
    bench::print(bench::compare(
        "loop wake lateness " + under + (p < 0.9 ? " p50" : " p99"), "bare clock_nanosleep loop",
        "us", [&] { return percentile(product(scene), p); }, [&] { return percentile(bare(), p); },
        1.2, 20));
  }
}

/// ns of one tick of so many devices of the scene that press, in one thread, in order; simulation
/// included.
double tick_ns(const server::Scene& scene, int devices) {
  bench::PressingUnits units(scene.devices.front(), devices);
  const double ns = bench::ns_per_call(kTicks, [&](int ticks) { units.tick(ticks); });
  units.check();
  return ns;
}

void measure(const char* path) {
  const server::Scene scene = server::load_scene(path);
  bench::print_header();
  bench::print(bench::compare(
      "tick of three devices that press", "three times that of one", "ns",
      [&] { return tick_ns(scene, 3); }, [&] { return 3.0 * tick_ns(scene, 1); }, 1.2));
  rows(scene, "idle");
  std::atomic<bool> stop{false};
  std::vector<std::thread> hogs;
  for (int i = 0; i < 2; ++i) {
    hogs.emplace_back([&stop] {
      volatile double x = 1.0;
      while (!stop.load(std::memory_order_relaxed)) x = x * 1.0000001;
    });
  }
  rows(scene, "beside two CPU hogs");
  stop = true;
  for (std::thread& hog : hogs) hog.join();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    measure(argc > 1 ? argv[1] : HAPTIC_SOURCE_DIR "/server/scenes/finger_constant.textproto");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "haptic-bench-loop: %s\n", error.what());
    return 1;
  }
  return 0;
}
