#pragma once
/// hapticd's server in one process, or as owner and front in two, in a process of its own whose
/// ticks the benchmark can see.

#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "server/base/steady_now.hpp"
#include "server/owner/link/front_program.hpp"
#include "tests/server/support/app.hpp"
#include "tests/support/percentile.hpp"

namespace haptic::bench {

using test::percentile;

/// How long each of the last ticks took, in memory that server and benchmark share.
struct TickTimes {
  struct Tick {
    float all_us, device_us;
  };
  std::atomic<std::uint64_t> count;
  std::array<Tick, std::size_t{1} << 15U> ticks;

  /// p50 of those from `first` on: from the wake-up to the device's command, and that without the
  /// time of Device::read.
  [[nodiscard]] std::array<double, 2> p50_us(std::uint64_t first) const {
    std::vector<double> all, without;
    for (std::uint64_t i = first; i < count.load(); ++i) {
      const Tick tick = ticks[i % ticks.size()];
      all.push_back(tick.all_us);
      without.push_back(tick.all_us - tick.device_us);
    }
    return {percentile(all, 0.5), percentile(without, 0.5)};
  }
};

/// A device that takes the time of its ticks.
class TimedDevice final : public hw::Device {
 public:
  TimedDevice(std::unique_ptr<hw::Device> device, TickTimes& times)
      : device_(std::move(device)), times_(times) {}
  [[nodiscard]] const hw::DeviceInfo& info() const noexcept override { return device_->info(); }
  void read(core::TimePoint now, core::DeviceReading& reading) noexcept override {
    const core::TimePoint begin = server::steady_now();
    device_->read(now, reading);
    read_ = server::steady_now() - begin;
  }
  void write(core::TimePoint now, const hw::Command& command) noexcept override {
    const auto us = [](core::Duration time) { return 1e-3F * static_cast<float>(time.count()); };
    const TickTimes::Tick tick{us(server::steady_now() - now), us(read_)};
    device_->write(now, command);
    const std::uint64_t number = times_.count.load(std::memory_order_relaxed);
    times_.ticks[number % times_.ticks.size()] = tick;
    times_.count.store(number + 1, std::memory_order_release);
  }
  void close() noexcept override { device_->close(); }

 private:
  const std::unique_ptr<hw::Device> device_;
  TickTimes& times_;
  core::Duration read_{};
};

class TimedConfig final : public hw::DeviceConfig {
 public:
  TimedConfig(std::shared_ptr<const hw::DeviceConfig> config, TickTimes& times)
      : config_(std::move(config)), times_(times) {}
  [[nodiscard]] std::unique_ptr<hw::Device> open(std::shared_ptr<const core::Kinematics> kinematics,
                                                 core::Duration longest_lateness) const override {
    return std::make_unique<TimedDevice>(config_->open(std::move(kinematics), longest_lateness),
                                         times_);
  }
  [[nodiscard]] core::VecA effort() const override { return config_->effort(); }
  [[nodiscard]] bool is_hardware() const noexcept override { return config_->is_hardware(); }

 private:
  const std::shared_ptr<const hw::DeviceConfig> config_;
  TickTimes& times_;
};

inline TickTimes& map_tick_times(int descriptor) {
  void* const memory = mmap(nullptr, sizeof(TickTimes), PROT_READ | PROT_WRITE,
                            MAP_SHARED | MAP_POPULATE, descriptor, 0);
  if (memory == MAP_FAILED) throw std::runtime_error("no memory for the times of ticks");
  return *static_cast<TickTimes*>(memory);
}

/// Keeps this process and what it starts off the last core, which is the loop's. Absent: there is
/// only one core.
inline std::optional<int> leave_a_core_to_the_loop() {
  cpu_set_t cores;
  sched_getaffinity(0, sizeof cores, &cores);
  int last = CPU_SETSIZE - 1;
  while (!CPU_ISSET(static_cast<std::size_t>(last), &cores)) --last;
  CPU_CLR(static_cast<std::size_t>(last), &cores);
  if (sched_setaffinity(0, sizeof cores, &cores) != 0) return std::nullopt;
  return last;
}

/// A server's process, until SIGTERM. `front`: the program of the front; empty: threads.
/// `loop_cpu`: the core of its loop; absent: any.
inline int serve(const std::string& scene_file, int port, int times, std::optional<int> loop_cpu,
                 const std::string& front) {
  sigset_t end;
  sigemptyset(&end);
  sigaddset(&end, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &end, nullptr);
  const std::string address = "127.0.0.1:" + std::to_string(port);
  std::vector<std::string> settings{"loop.late_bucket_full=1000000",
                                    "server.listen=[\"" + address + "\"]",
                                    "server.udp_listen=\"" + address + "\""};
  if (loop_cpu) settings.push_back("loop.cpu=" + std::to_string(*loop_cpu));
  server::Scene scene = server::load_scene(scene_file, settings);
  std::optional<server::Launcher> launcher;
  if (!front.empty()) launcher.emplace(front, server::front_limits(scene));
  spdlog::set_level(spdlog::level::warn);
  auto& source = scene.devices.front().source;
  source = std::make_shared<TimedConfig>(source, map_tick_times(times));
  const server::AppOptions options{server::RealtimeMode::kTry, false, "warn"};
  std::unique_ptr<server::App> app;
  if (launcher) {
    app = std::make_unique<server::App>(std::move(scene), options, [&](server::App& owner) {
      return server::front_process(owner, &*launcher, [] {});
    });
  } else {
    app = std::make_unique<test::App>(std::move(scene), options);
  }
  app->start();
  int signal = 0;
  sigwait(&end, &signal);
  app->stop();
  return 0;
}

/// Such a process, which this program starts from itself: --serve PORT TIMES LOOP_CPU [FRONT].
class ServerProcess {
 public:
  ServerProcess(int port, std::optional<int> loop_cpu, const std::string& front)
      : descriptor_(memfd_create("tick-times", 0)),  // passed on by exec
        sized_(ftruncate(descriptor_, sizeof(TickTimes)) == 0),
        times_(map_tick_times(descriptor_)),
        id_(fork()) {
    if (id_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    const std::string at = std::to_string(port), times = std::to_string(descriptor_);
    const std::string cpu = std::to_string(loop_cpu.value_or(-1));
    const char* const last = front.empty() ? nullptr : front.c_str();
    execl("/proc/self/exe", "haptic-bench-crossing", "--serve", at.c_str(), times.c_str(),
          cpu.c_str(), last, nullptr);
    _exit(127);
  }
  ~ServerProcess() {
    kill(id_, SIGTERM);
    waitpid(id_, nullptr, 0);
    munmap(&times_, sizeof(TickTimes));
    close(descriptor_);
  }
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  [[nodiscard]] const TickTimes& times() const { return times_; }

 private:
  const int descriptor_;
  const bool sized_;
  TickTimes& times_;
  const pid_t id_;
};

}  // namespace haptic::bench
