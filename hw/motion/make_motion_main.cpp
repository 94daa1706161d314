/// haptic-make-motion: writes a CSV of finger motion that hapticd's replay and simulated finger
/// play.

#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <string>

#include "haptic/core/error.hpp"
#include "hw/motion/reach_and_grasp.hpp"

namespace {

int run(const haptic::hw::ReachAndGrasp& options, const std::string& output) {
  const auto rows = haptic::hw::make_reach_and_grasp(options);
  if (output == "-") {
    haptic::hw::write_motion_csv(std::cout, rows);
    return std::cout.flush() ? 0 : 1;
  }
  std::ofstream file(output, std::ios::binary);
  haptic::hw::write_motion_csv(file, rows);
  if (file.close(), file) return 0;
  std::cerr << output << ": cannot be written\n";
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  haptic::hw::ReachAndGrasp options;
  std::string output = "-";
  CLI::App app{
      "Writes reach-and-grasp motion of an index finger as CSV "
      "(time_s,q_o1_mcp_rad,q_o2_pip_rad). The same options give the same file."};
  app.add_option("--seed", options.seed, "Seed of the variation between strokes")
      ->capture_default_str();
  app.add_option("--seconds", options.seconds, "Length of the motion")->capture_default_str();
  app.add_option("--rate", options.rate, "Rows per second, 1 to 1000")->capture_default_str();
  app.add_option("--tremor", options.tremor_rms, "Tremor, rad rms per joint")
      ->capture_default_str();
  app.add_option("--output", output, "File to write; - for standard output")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    return run(options, output);
  } catch (const haptic::core::DeviceError& error) {
    std::cerr << "haptic-make-motion: " << error.what() << '\n';
    return 2;
  }
}
