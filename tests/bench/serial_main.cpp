/// What a serial link to a board is like: age of samples at the tick, round trip, what was lost and
/// why. A 1 kHz loop that arms and presses 2 N, on a port given or on an emulator of its own.
///
///   haptic-bench-serial [SECONDS [LINK-PERIOD-MS | PORT]]     default 20 s, emulator, streaming

#include <time.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/board/board_device.hpp"
#include "hw/emulator/serve.hpp"
#include "hw/open_device.hpp"
#include "hw/thread_priority.hpp"
#include "tests/bench/percentile.hpp"

namespace {

using namespace haptic;
using bench::percentile;

core::TimePoint now() {
  return core::TimePoint(std::chrono::steady_clock::now().time_since_epoch());
}

void wait_until(core::TimePoint t) {
  const auto ns = t.time_since_epoch().count();
  const timespec deadline{ns / 1'000'000'000, ns % 1'000'000'000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr) != 0) {
  }
}

struct Measured {
  std::vector<double> age_ms{};
  double longest_silence_ms{0.0};
  double latest_tick_ms{0.0};  ///< of this loop: what is beyond it is not the link's doing
  int lost_ticks{0};           ///< with health other than kOk
};

Measured run(hw::Device& device, int seconds) {
  hw::ask_for_priority(80);  // as hapticd's loop
  Measured measured;
  measured.age_ms.reserve(static_cast<std::size_t>(1000 * seconds));
  hw::Command command;
  command.arm = true;
  command.tau_a = core::VecA::Constant(1, 2.0);
  core::DeviceReading reading;
  core::TimePoint tick = now(), last_fresh = tick;
  for (int i = 0; i < 1000 * seconds; ++i) {
    wait_until(tick += std::chrono::milliseconds(1));
    const core::TimePoint at = now();
    measured.latest_tick_ms = std::max(measured.latest_tick_ms, 1e3 * core::seconds(at - tick));
    device.read(at, reading);
    device.write(at, command);
    if (reading.health != core::DeviceHealth::kOk) ++measured.lost_ticks;
    if (reading.fresh) last_fresh = at;
    measured.longest_silence_ms =
        std::max(measured.longest_silence_ms, 1e3 * core::seconds(at - last_fresh));
    if (reading.sample.seq == 0) continue;
    measured.age_ms.push_back(1e3 * core::seconds(at - reading.sample.time));
  }
  return measured;
}

void print(const Measured& m, const hw::board::HostCounters& n) {
  std::printf("age of the sample at the tick, ms: p50 %.3f, p99 %.3f, p99.9 %.3f, max %.3f\n",
              percentile(m.age_ms, 0.5), percentile(m.age_ms, 0.99), percentile(m.age_ms, 0.999),
              percentile(m.age_ms, 1.0));
  std::printf("longest silence %.1f ms; ticks without a healthy board %d; latest tick %.1f ms\n",
              m.longest_silence_ms, m.lost_ticks, m.latest_tick_ms);
  std::printf("round trip, ms: last %.3f, longest %.3f\n", 1e3 * core::seconds(n.round_trip),
              1e3 * core::seconds(n.longest_round_trip));
  std::printf(
      "host: frames %llu, states %llu, lost %llu, bad CRC %llu, malformed %llu, not newer "
      "%llu, sent %llu, held back %llu, handshakes %llu\n",
      static_cast<unsigned long long>(n.frames), static_cast<unsigned long long>(n.states),
      static_cast<unsigned long long>(n.lost), static_cast<unsigned long long>(n.bad_crc),
      static_cast<unsigned long long>(n.malformed), static_cast<unsigned long long>(n.not_newer),
      static_cast<unsigned long long>(n.sent),
      static_cast<unsigned long long>(n.commands_held_back),
      static_cast<unsigned long long>(n.handshakes));
  std::printf(
      "board: accepted %u, bad CRC %u, malformed %u, not newer %u, wrong nonce %u, watchdog "
      "stops %u, frames without room %u\n",
      n.board.accepted, n.board.bad_crc, n.board.malformed, n.board.not_newer, n.board.wrong_nonce,
      n.board.watchdog_stops, n.board.states_dropped);
}

}  // namespace

int main(int argc, char** argv) {
  const int seconds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 20;
  const std::string what = argc > 2 ? argv[2] : "0";
  const std::shared_ptr<const core::Kinematics> kinematics = core::make_finger_exoskeleton({});
  hw::BoardConfig config;
  config.max_effort = core::VecA::Constant(1, 40.0);
  config.port = what;

  hw::emulator::EmulatorConfig emulated;
  hw::emulator::PseudoTerminal terminal("");
  std::atomic<bool> stop{false};
  std::thread emulator;
  const bool own = what.empty() || what[0] != '/';
  if (own) {
    emulated.link_period_us = static_cast<std::uint32_t>(1e3 * std::atof(what.c_str()));
    config.port = terminal.port();
  }
  hw::emulator::EmulatedBoard board(emulated, {Eigen::Vector2d::Zero(), Eigen::Vector2d(0.5, 0.5)},
                                    kinematics);
  if (own) emulator = std::thread([&] { serve(board, terminal, stop); });

  hw::BoardDevice device(config, kinematics, core::Duration{0});
  const Measured measured = run(device, seconds);
  print(measured, device.counters());
  device.close();
  stop = true;
  if (emulator.joinable()) emulator.join();
  return 0;
}
