/// haptic-board-emulator: the finger exoskeleton's board on a pseudo-terminal.

#include <pthread.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <map>
#include <optional>
#include <string>
#include <thread>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/emulator/serve.hpp"
#include "hw/emulator/told_hand.hpp"
#include "hw/emulator/truth_log.hpp"

namespace {

using namespace haptic;
using hw::emulator::BoardControl;
using hw::emulator::EmulatedBoard;
using hw::emulator::EmulatorConfig;

struct CommandLine {
  EmulatorConfig board{};
  std::string link{}, motion{}, truth{};
  bool hand{false};
  double watchdog_ms{25.0}, link_period_ms{0.0};
  std::vector<std::string> faults{};
};

void describe(CLI::App& app, CommandLine& c) {
  app.add_option("--link", c.link, "path of a symbolic link to the port, kept across unplugging");
  app.add_option("--seed", c.board.seed, "of noise and of damaged bytes");
  app.add_option("--serial", c.board.serial, "serial number of the board (up to 16 characters)");
  app.add_option("--watchdog-ms", c.watchdog_ms, "the board's watchdog")
      ->check(CLI::Range(1.0, 1000.0));
  app.add_option("--link-period-ms", c.link_period_ms,
                 "bytes pass only this often, both ways; 2: the paper's 500 Hz; 0: at once")
      ->check(CLI::Range(0.0, 100.0));
  const std::map<std::string, BoardControl> controls{{"force-loop", BoardControl::kForceLoop},
                                                     {"drive", BoardControl::kDrive},
                                                     {"position", BoardControl::kPosition}};
  app.add_option("--control", c.board.control,
                 "what the board makes of a command: force-loop, drive (force), position")
      ->transform(CLI::CheckedTransformer(controls));
  app.add_option("--l-x-scale", c.board.l_x_scale, "error of the potentiometer of l_x: its scale");
  app.add_option("--l-x-offset", c.board.l_x_offset, "and its offset, m");
  app.add_option("--force-offset", c.board.force_offset, "N that the load cell reads without load");
  app.add_option("--drop", c.board.drop, "share of bytes lost")->check(CLI::Range(0.0, 1.0));
  app.add_option("--corrupt", c.board.corrupt, "share of bytes with a bit flipped")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--fault", c.faults, "KIND@START[+LENGTH][=AMOUNT], as often as wanted");
  app.add_option("--motion", c.motion,
                 "CSV of joint angles that the user follows; otherwise the finger stays straight");
  app.add_flag("--hand", c.hand,
               "lines of standard input move the hand: MCP PIP in rad, or let-go");
  app.add_option("--truth", c.truth, "CSV of what rod, linkage and load cell really do");
}

EmulatorConfig resolved(const CommandLine& c) {
  EmulatorConfig config = c.board;
  config.watchdog_us = static_cast<std::uint32_t>(1e3 * c.watchdog_ms);
  config.link_period_us = static_cast<std::uint32_t>(1e3 * c.link_period_ms);
  for (const std::string& fault : c.faults) {
    config.faults.push_back(hw::emulator::parse_fault(fault));
  }
  return config;
}

hw::HandIntent intent(const CommandLine& c, const core::Kinematics& finger) {
  const core::VecQ straight = core::VecQ::Zero(2);
  if (c.motion.empty()) return {straight, straight};
  return {{.fingers = {{}}}, straight, finger, c.motion};
}

/// One line on standard error whenever something begins or ends.
class Reporter {
 public:
  void operator()(const EmulatedBoard& board) {
    static constexpr const char* kStates[] = {"DISARMED", "ARMED", "STOPPED", "FAULT"};
    const auto state = board.firmware().state;
    if (state == state_ && board.drives() == drives_ && board.plugged() == plugged_) return;
    state_ = state;
    drives_ = board.drives();
    plugged_ = board.plugged();
    std::fprintf(stderr, "%.3f s: %s, drive %s, %s, force %.2f N, faults %u\n",
                 static_cast<double>(board.now_us()) * 1e-6, kStates[state], drives_ ? "on" : "off",
                 plugged_ ? "plugged" : "unplugged", board.rig().actuator().force(),
                 static_cast<unsigned>(board.firmware().faults));
  }

 private:
  hb_state state_{HB_DISARMED};
  bool drives_{false};
  bool plugged_{true};
};

void print_counters(const EmulatedBoard& board) {
  const hb_counters& n = board.firmware().counters;
  std::fprintf(
      stderr,
      "accepted %u, bad CRC %u, malformed %u, not newer %u, wrong nonce %u, watchdog stops "
      "%u, frames without room %u, sessions %u\n",
      n.accepted, n.bad_crc, n.malformed, n.not_newer, n.wrong_nonce, n.watchdog_stops,
      n.states_dropped, n.sessions);
}

int run(const CommandLine& c) {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);

  std::shared_ptr<const core::Kinematics> kinematics = core::make_finger_exoskeleton({});
  EmulatedBoard board(resolved(c), intent(c, *kinematics), kinematics);
  std::optional<hw::emulator::TruthLog> truth;
  if (!c.truth.empty()) truth.emplace(c.truth);
  hw::emulator::PseudoTerminal terminal(c.link);
  std::printf("%s\n", c.link.empty() ? terminal.port().c_str() : c.link.c_str());
  std::fflush(stdout);

  std::atomic<bool> stop{false};
  std::thread waiter([&] {
    int signal = 0;
    sigwait(&signals, &signal);
    stop = true;
  });
  hw::emulator::ToldHand hand(c.hand ? STDIN_FILENO : -1);
  hw::emulator::serve(board, terminal, stop, [&, report = Reporter()](EmulatedBoard& now) mutable {
    hand.follow(now.rig());
    if (truth) truth->write(now);
    report(now);
  });
  waiter.join();
  print_counters(board);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CommandLine command_line;
  CLI::App app("The board of a finger exoskeleton on a pseudo-terminal");
  describe(app, command_line);
  CLI11_PARSE(app, argc, argv);
  try {
    return run(command_line);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "haptic-board-emulator: %s\n", error.what());
    return 1;
  }
}
