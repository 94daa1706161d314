/// hapticctl: look at a server and its devices, ask for force, stop, clear.
/// Exit codes: 0 done, 1 refused or failed, 2 bad command line.

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>

#include "commands.hpp"

namespace {

/// A number from `lowest` to `highest`; CLI::Range lets nan through.
CLI::Validator between(double lowest, double highest) {
  return {[=](std::string& text) {
            double value = std::nan("");
            const bool number = CLI::detail::lexical_cast(text, value);
            if (number && value >= lowest && value <= highest) return std::string();
            return "must be a number from " + CLI::detail::to_string(lowest) + " to " +
                   CLI::detail::to_string(highest);
          },
          "NUMBER"};
}

constexpr double kLongest = 1e9;  // s

}  // namespace

int main(int argc, char** argv) {
  haptic::ctl::Options options;
  CLI::App cli("hapticctl - command-line client of hapticd");
  cli.require_subcommand(1);
  cli.fallthrough();
  cli.add_option("--server", options.server, "host:port or unix:/path")->capture_default_str();
  cli.add_option("--device", options.device,
                 "its name; default: the only one; of watch, info and estop: all");

  CLI::App* info = cli.add_subcommand("info", "the server, its real-time grade, its devices");
  info->add_flag("--json", options.json, "one JSON object");
  CLI::App* watch = cli.add_subcommand("watch", "live tables of the devices");
  watch->add_flag("--json", options.json, "one JSON object per line, for scripts");
  watch->add_option("--rate", options.rate_hz, "lines or refreshes per second")
      ->check(between(1.0, 1000.0));
  watch->add_option("--seconds", options.seconds, "stop after this long; 0: until interrupted")
      ->check(between(0.0, kLongest));
  CLI::App* engage =
      cli.add_subcommand("engage", "take the lease, engage, print states until interrupted");
  engage->add_flag("--hold", options.hold,
                   "hold the device where it is (default: free, no force at all)");
  engage->add_option("--seconds", options.seconds, "stop after this long; 0: until interrupted")
      ->check(between(0.0, kLongest));
  CLI::App* stop = cli.add_subcommand("estop", "zero force now, latched");
  stop->add_option("--reason", options.reason, "for the log");
  CLI::App* clear = cli.add_subcommand("clear-fault", "clear latched faults");
  clear->add_option("fault", options.faults, "fault numbers; none: all that are active")
      ->check(CLI::Range(1, 31));
  CLI::App* doctor =
      cli.add_subcommand("doctor", "is this host fit, and how stiff may a spring be");
  doctor->add_flag("--json", options.json, "one JSON object");
  doctor->add_option("--seconds", options.seconds, "of measuring the loop's jitter; default 10")
      ->check(between(0.1, 3600.0));
  doctor->add_option("--device-damping", options.device_damping, "b of the device, N s/m")
      ->check(between(0.0, 1e6))
      ->capture_default_str();
  doctor->add_option("--damping", options.damping, "B of the scene, N s/m")
      ->check(between(0.0, 1e6))
      ->capture_default_str();
  CLI::App* calibrate =
      cli.add_subcommand("calibrate", "find out, step by step, what a board's sensors really mean");
  calibrate->add_option("--output", options.output, "the file to write; default SERIAL.textproto");

  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return cli.exit(error) == 0 ? 0 : 2;
  }
  try {
    if (*info) return haptic::ctl::info(options);
    if (*watch) return haptic::ctl::watch(options);
    if (*engage) return haptic::ctl::engage(options);
    if (*stop) return haptic::ctl::estop(options);
    if (*doctor) return haptic::ctl::doctor(options);
    if (*calibrate) return haptic::ctl::calibrate(options);
    return haptic::ctl::clear_fault(options);
  } catch (const haptic::client::ClientError& error) {
    if (error.reason() == haptic::client::ErrorReason::kUnreachable) {
      std::fprintf(stderr, "hapticctl: no hapticd answers at %s\n", options.server.c_str());
    }
    std::fprintf(stderr, "hapticctl: %s%s%s\n", error.what(),
                 error.server_reason().empty() ? "" : " - ", error.server_reason().c_str());
    return 1;
  }
}
