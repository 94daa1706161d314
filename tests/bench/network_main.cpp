/// haptic-bench-network: the measurements of the network's path, by the rule of
/// CONTRIBUTING.md#measuring. tests/bench/network.sh runs it.
///
///   haptic-bench-network [udp|age]... [--blocks N]
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "tests/bench/network.hpp"
#include "tests/bench/paired.hpp"

int main(int argc, char** argv) {
  namespace bench = haptic::bench;
  std::vector<std::string> parts;
  int blocks = 20;
  CLI::App cli("haptic-bench-network - what the network's path costs");
  cli.add_option("parts", parts, "udp, age; none: all")->check(CLI::IsMember({"udp", "age"}));
  cli.add_option("--blocks", blocks, "alternations; of fewer than 20 nothing may be quoted")
      ->check(CLI::Range(2, 1000));
  CLI11_PARSE(cli, argc, argv);
  const auto wanted = [&](const char* part) {
    return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end();
  };
  spdlog::set_level(spdlog::level::warn);  // sessions that come and go
  bench::print_header();
  try {
    if (wanted("udp")) bench::udp_one_way(blocks);
    if (wanted("age")) bench::age_at_use(blocks);
  } catch (const std::exception& error) {
    std::cerr << "haptic-bench-network: " << error.what() << "\n";
    return 1;
  }
  return 0;
}
