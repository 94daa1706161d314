#pragma once
/// hapticctl's command line, its variables of the environment and its configuration file.

#include <variant>

#include "commands.hpp"

namespace haptic::ctl {

using Command = int (*)(const Options&);

/// An option takes its value from the command line, else from its variable, else from the
/// configuration file, else its default. Returns the command to run, or, after --help, --version or
/// an error that it printed, the exit status.
[[nodiscard]] std::variant<Command, int> parse(int argc, char** argv, Options& options);

}  // namespace haptic::ctl
