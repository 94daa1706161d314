#pragma once
/// The subcommands of haptic-report, one file each. Every one prints CSV with a header line on
/// standard output and nothing else there; remarks go to standard error.

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>

namespace haptic::report {

/// True if an option names nothing, or this.
[[nodiscard]] inline bool chosen(const std::string& option, std::string_view name) {
  return option.empty() || option == name;
}

/// An option of two numbers, "A,B".
template <typename To>
CLI::Option* add_pair(CLI::App& command, const std::string& name, To& to, const std::string& help) {
  return command.add_option(name, to, help)->delimiter(',')->check(CLI::Range(-1000.0, 1000.0));
}

void add_linkage(CLI::App& app);
void add_fig4(CLI::App& app);
void add_claims(CLI::App& app);
void add_scan(CLI::App& app);
void add_radius(CLI::App& app);
void add_finger(CLI::App& app);
void add_feel(CLI::App& app);
void add_felt(CLI::App& app);
void add_bound(CLI::App& app);
void add_closed_loop(CLI::App& app);
void add_press(CLI::App& app);
void add_rate(CLI::App& app);
void add_rtt(CLI::App& app);
void add_scaling(CLI::App& app);
void add_work_precision(CLI::App& app);

}  // namespace haptic::report
