#pragma once
/// Shared by all examples: the option --server, Ctrl-C, and events and errors in words.

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>

#include "haptic/client/client.hpp"

namespace haptic::examples {

inline volatile std::sig_atomic_t stop_requested = 0;  ///< by SIGINT or SIGTERM

inline void print_event(const client::Event& event) {
  std::fprintf(stderr, "%s: %s\n", event.reason.c_str(), event.message.c_str());
}

inline void print_end(const client::ClientError& error, bool will_retry) {
  std::fprintf(stderr, "the session ended: %s%s\n", error.what(),
               will_retry ? "; trying again" : "");
}

/// Reads the command line into `cli`, connects, and runs `body`, which returns the exit status.
template <typename Body>
int run(CLI::App& cli, int argc, char** argv, Body body) {
  std::string address = client::kDefaultServer;
  cli.add_option("--server", address, "host:port or unix:/path");
  CLI11_PARSE(cli, argc, argv);
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stop_requested = 1; });
  try {
    client::Connection server(address);
    return body(server);
  } catch (const client::ClientError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}

}  // namespace haptic::examples
