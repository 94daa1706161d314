/// hapticctl: looks at a server and its devices, asks for force, stops, clears faults.

#include <cstdio>

#include "command_line.hpp"
#include "exit_status.hpp"

int main(int argc, char** argv) {
  using haptic::client::ClientError;
  haptic::ctl::Options options;
  const auto parsed = haptic::ctl::parse(argc, argv, options);
  if (const int* const status = std::get_if<int>(&parsed)) return *status;
  try {
    return std::get<haptic::ctl::Command>(parsed)(options);
  } catch (const ClientError& error) {
    const haptic::ctl::ExitStatus status = haptic::ctl::exit_status(error);
    if (status == haptic::ctl::kUnreachable) {
      std::fprintf(stderr, "hapticctl: no hapticd answers at %s\n", options.server.c_str());
    }
    std::fprintf(stderr, "hapticctl: %s%s%s\n", error.what(),
                 error.server_reason().empty() ? "" : " - ", error.server_reason().c_str());
    return status;
  }
}
