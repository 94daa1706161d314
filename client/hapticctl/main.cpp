/// hapticctl: look at a server and its devices, ask for force, stop, clear.
/// Exit codes: 0 done, 1 refused or failed, 2 bad command line.

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>

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

using haptic::client::Priority;
const std::map<std::string, Priority> priorities{
    {"test", Priority::kTest}, {"primary", Priority::kPrimary}, {"operator", Priority::kOperator}};

}  // namespace

int main(int argc, char** argv) {
  haptic::ctl::Options options;
  CLI::App cli("hapticctl - command-line client of hapticd");
  cli.require_subcommand(0, 1);  // an unknown command is then named, not called missing
  cli.fallthrough();
  cli.add_option("--server", options.server, "host:port or unix:/path")->capture_default_str();
  cli.add_option("--device", options.device,
                 "its name; default: the only one; of watch, info, health and estop: all");

  CLI::Option* tls = cli.add_flag("--tls", options.tls, "TLS; the system's list of issuers");
  CLI::Option* ca = cli.add_option("--ca", options.tls_options.ca_file,
                                   "PEM file: who issued the server's certificate; means --tls");
  CLI::Option* certificate = cli.add_option("--cert", options.tls_options.certificate_file,
                                            "PEM file: this client's certificate; means --tls");
  CLI::Option* key = cli.add_option("--key", options.tls_options.key_file, "PEM file: its key");
  certificate->needs(key);
  key->needs(certificate);
  CLI::Option* server_name =
      cli.add_option("--server-name", options.tls_options.server_name,
                     "name in the server's certificate, if not the address's; means --tls");

  CLI::App* info = cli.add_subcommand("info", "the server, its real-time grade, its devices");
  info->add_flag("--json", options.json, "one JSON object");
  CLI::App* health = cli.add_subcommand(
      "health", "0 while the devices are open and the loop is on time, else 1: for scripts");
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
  engage
      ->add_option_function<std::string>(
          "--priority", [&](const std::string& word) { options.priority = priorities.at(word); },
          "how it gets the lease from others")
      ->check(CLI::IsMember(priorities));
  CLI::App* link = cli.add_subcommand("link", "what the links of the open sessions are doing");
  link->add_flag("--json", options.json, "one JSON object");
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
    if (cli.get_subcommands().empty()) {
      throw CLI::RequiredError("a command: info, watch, engage, estop or clear-fault");
    }
  } catch (const CLI::ParseError& error) {
    return cli.exit(error) == 0 ? 0 : 2;
  }
  options.tls = *tls || *ca || *certificate || *server_name;
  try {
    if (*info) return haptic::ctl::info(options);
    if (*health) return haptic::ctl::health(options);
    if (*watch) return haptic::ctl::watch(options);
    if (*engage) return haptic::ctl::engage(options);
    if (*link) return haptic::ctl::link(options);
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
