#include "command_line.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>

#include "haptic/wire/ports.hpp"

namespace haptic::ctl {
namespace {

constexpr double kLongest = 1e9;  // s

const std::map<std::string, client::Priority> kPriorities{
    {"test", client::Priority::kTest},
    {"primary", client::Priority::kPrimary},
    {"operator", client::Priority::kOperator}};

constexpr std::pair<const char*, const char*> kVariables[] = {
    {"HAPTIC_CONFIG", "--config"}, {"HAPTIC_SERVER", "--server"},
    {"HAPTIC_CA", "--ca"},         {"HAPTIC_CERT", "--cert"},
    {"HAPTIC_KEY", "--key"},       {"HAPTIC_SERVER_NAME", "--server-name"},
};

/// Below the options of --help, and in the man page.
const std::string kFooter =
    "Values:\n"
    "  An option is taken from the command line, else from its variable, else from the\n"
    "  configuration file, else its default.\n"
    "  variables: HAPTIC_SERVER, HAPTIC_CA, HAPTIC_CERT, HAPTIC_KEY, HAPTIC_SERVER_NAME,\n"
    "  HAPTIC_CONFIG. A line of the file: server = \"robot:" +
    std::to_string(wire::kGrpcPort) +
    "\"\n\n"
    "Exit status:\n"
    "  0  done; estop: stopped, locally or over the network, as the answer says: a local stop\n"
    "     is cleared on that host alone, one over the network by every client that may control\n"
    "  1  failed; health: not serving; doctor: the host is unfit\n"
    "  2  bad command line, variable or configuration file\n"
    "  3  no hapticd answers at the address; find: none announces itself\n"
    "  4  hapticd refused what was asked\n"
    "  5  the device is in FAULT\n";

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

/// A fault by its name, in any case, or by its number, which it becomes.
CLI::Validator fault() {
  return {[](std::string& text) {
            std::string names;
            for (std::uint32_t number = 1; number < 32; ++number) {
              const std::string name = client::fault_names(1U << number).front();
              const std::string digits = std::to_string(number);
              if (CLI::detail::to_lower(name) == CLI::detail::to_lower(text)) text = digits;
              if (text == digits) return std::string();
              if (name != digits) names += (names.empty() ? "" : ", ") + name;
            }
            return "'" + text + "' must be a number from 1 to 31 or one of " + names;
          },
          "FAULT"};
}

/// Editors of Windows put a byte order mark at the beginning.
struct Toml final : CLI::ConfigTOML {
  std::vector<CLI::ConfigItem> from_config(std::istream& text) const override {
    const int first = text.peek();
    if (first >= 0xFE) throw CLI::FileError("is UTF-16, must be UTF-8");
    if (first == 0xEF) text.ignore(3);
    return CLI::ConfigTOML::from_config(text);
  }
};

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

std::filesystem::path default_config_file() {
  const std::string folder = variable("XDG_CONFIG_HOME");
  return std::filesystem::path(folder.empty() ? variable("HOME") + "/.config" : folder) /
         "hapticctl.toml";
}

/// Puts the variables in front of the command line as options: the last value of an option counts,
/// and CLI11 reads from the configuration file only what has no value yet. In CLI11's order, last
/// argument first.
std::vector<std::string> arguments(int argc, char** argv) {
  std::vector<std::string> all;
  const std::filesystem::path file = default_config_file();
  if (std::error_code error; std::filesystem::exists(file, error)) {
    all.push_back("--config=" + file.string());
  }
  for (const auto& [name, option] : kVariables) {
    if (const std::string value = variable(name); !value.empty()) {
      all.push_back(std::string(option) + "=" + value);
    }
  }
  all.insert(all.end(), argv + 1, argv + argc);
  std::reverse(all.begin(), all.end());
  return all;
}

/// Options that every command takes. Any of the TLS options means --tls.
void add_common(CLI::App& cli, Options& options) {
  const auto text = [&](const char* name, std::string& value, const char* what) {
    return cli.add_option(name, value, what)->take_last();
  };
  client::TlsOptions& tls = options.tls_options;
  cli.set_version_flag("--version", "hapticctl " HAPTIC_VERSION);
  cli.set_config("--config", "", "configuration file (TOML), by default ~/.config/hapticctl.toml")
      ->take_last()
      ->type_name("FILE");
  text("--server", options.server, "host:port or unix:/path; local:SCENE for one offline")
      ->capture_default_str();
  text("--device", options.device,
       "name of a device; default: the only one, for watch, info, health and estop all");
  cli.add_flag("--json", options.json, "print JSON: one object, or one per line");
  cli.add_flag("--tls", options.tls, "use TLS, with the system's list of issuers");
  text("--ca", tls.ca_file, "PEM file: issuers of the server's certificate; means --tls");
  CLI::Option* certificate =
      text("--cert", tls.certificate_file, "PEM file: this client's certificate; means --tls");
  certificate->needs(
      text("--key", tls.key_file, "PEM file: the key of --cert")->needs(certificate));
  text("--server-name", tls.server_name,
       "name in the server's certificate, if not the address's; means --tls");
}

CLI::App* add(CLI::App& cli, const char* name, Command command, Command& chosen, const char* what) {
  CLI::App* const added = cli.add_subcommand(name, what);
  added->callback([command, &chosen] { chosen = command; });
  return added;
}

void add_commands(CLI::App& cli, Options& options, Command& chosen) {
  const auto seconds = [&options](CLI::App* to) {
    to->add_option("--seconds", options.seconds, "stop after this long; 0: until interrupted")
        ->check(between(0.0, kLongest));
  };
  add(cli, "info", info, chosen, "show the server, its real-time grade and its devices");
  add(cli, "health", health, chosen,
      "end with 0 while the devices are open and the loop is on time, else with 1");
  CLI::App* const watching = add(cli, "watch", watch, chosen, "show the devices live");
  watching->add_option("--rate", options.rate_hz, "lines or refreshes per second")
      ->check(between(1.0, 1000.0))
      ->capture_default_str();
  seconds(watching);
  CLI::App* const engaging =
      add(cli, "engage", engage, chosen, "take the lease, engage, print states until interrupted");
  engaging->add_flag("--hold", options.hold,
                     "hold the device where it is (default: free, no force at all)");
  seconds(engaging);
  engaging
      ->add_option_function<std::string>(
          "--priority",
          [&options](const std::string& word) { options.priority = kPriorities.at(word); },
          "whose lease it may take: test, primary or operator")
      ->check(CLI::IsMember(kPriorities));
  add(cli, "link", link, chosen, "show what the links of the open sessions are doing");
  add(cli, "estop", estop, chosen, "set the force to zero now; a fault stays latched")
      ->add_option("--reason", options.reason, "for the log");
  add(cli, "clear-fault", clear_fault, chosen, "clear latched faults")
      ->add_option("fault", options.faults, "names or numbers of faults; none: all active ones")
      ->transform(fault());
  add(cli, "restart-front", restart_front, chosen,
      "replace the process that faces the network; devices and leases go on");
  CLI::App* const examining = add(cli, "doctor", doctor, chosen,
                                  "say whether this host is fit, and how stiff a spring may be");
  examining->add_option("--seconds", options.seconds, "of measuring the loop's jitter; default 10")
      ->check(between(0.1, 3600.0));
  examining->add_option("--device-damping", options.device_damping, "b of the device, N s/m")
      ->check(between(0.0, 1e6))
      ->capture_default_str();
  examining->add_option("--damping", options.damping, "B of the scene, N s/m")
      ->check(between(0.0, 1e6))
      ->capture_default_str();
  add(cli, "calibrate", calibrate, chosen, "measure, step by step, what a board's sensors read")
      ->add_option("--output", options.output, "the file to write; default SERIAL.textproto");
  add(cli, "find", find, chosen, "list the servers that announce themselves on this network")
      ->add_option("--seconds", options.seconds,
                   "look for this long; 0: until the Avahi daemon has named all it knows")
      ->check(between(0.0, 3600.0));
}

void define(CLI::App& cli, Options& options, Command& chosen) {
  cli.require_subcommand(0, 1);  // CLI11 then names an unknown command instead of a missing one
  cli.fallthrough();
  cli.allow_config_extras(CLI::config_extras_mode::error);
  cli.config_formatter(std::make_shared<Toml>());
  cli.footer("The options of hapticctl itself, such as --server and --json, apply too.");
  add_common(cli, options);
  add_commands(cli, options, chosen);
  cli.footer(kFooter);
}

/// "FILE:LINE: what is wrong" for the first wrong line of a configuration file; empty if every line
/// is right. CLI11 says neither, so this reads the file again, one more line at a time.
std::string config_problem(const std::string& file) {
  std::ifstream stream(file);
  std::string text, line;
  for (int number = 1; std::getline(stream, line); ++number) {
    text += line + "\n";
    const std::string place = file + ":" + std::to_string(number) + ": ";
    CLI::App cli;
    Options options;
    Command chosen = nullptr;
    define(cli, options, chosen);
    std::istringstream lines(text);
    try {
      cli.parse_from_stream(lines);
    } catch (const CLI::RequiresError&) {  // what it requires may stand further below
    } catch (const CLI::ConfigError&) {
      return place + "no option of hapticctl: " + line;
    } catch (const CLI::ParseError& error) {
      return place + error.what();
    }
  }
  return {};
}

}  // namespace

std::variant<Command, int> parse(int argc, char** argv, Options& options) {
  CLI::App cli("hapticctl - command-line client of hapticd", "hapticctl");
  Command chosen = nullptr;
  define(cli, options, chosen);
  try {
    cli.parse(arguments(argc, argv));
    if (chosen == nullptr) throw CLI::RequiredError("a command");
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return cli.exit(error);
    const auto& configs = cli.get_config_ptr()->results();
    const std::string wrong = configs.empty() ? "" : config_problem(configs.back());
    if (wrong.empty()) {
      cli.exit(error);
    } else {
      std::cerr << "hapticctl: " << wrong << "\n";
    }
    return kUsage;
  }
  const client::TlsOptions& tls = options.tls_options;
  options.tls = options.tls || !tls.ca_file.empty() || !tls.certificate_file.empty() ||
                !tls.server_name.empty();
  return chosen;
}

}  // namespace haptic::ctl
