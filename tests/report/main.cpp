/// haptic-report: the figures of the study, as CSV on standard output; tests/report/run.sh makes
/// plots of them. Exit status: 0; 2 if the figure could not be made.
#include <cstdio>

#include "haptic/core/error.hpp"
#include "tests/report/chosen_linkage.hpp"
#include "tests/report/command.hpp"

int main(int argc, char** argv) {
  CLI::App app{"Figures of rendering through underactuated devices, as CSV on standard output"};
  app.require_subcommand(1);
  app.add_option_function<std::string>(
         "--linkage",
         [](const std::string& name) {
           if (name == "finger_sign_change") {
             haptic::report::chosen_linkage() = haptic::core::finger_sign_change();
           }
         },
         "of the finger, before the subcommand; default: finger_same_sign")
      ->check(CLI::IsMember({"finger_same_sign", "finger_sign_change"}));
  haptic::report::add_linkage(app);
  haptic::report::add_fig4(app);
  haptic::report::add_claims(app);
  haptic::report::add_scan(app);
  haptic::report::add_radius(app);
  haptic::report::add_finger(app);
  haptic::report::add_closed_loop(app);
  haptic::report::add_press(app);
  haptic::report::add_rate(app);
  haptic::report::add_rtt(app);
  haptic::report::add_felt(app);
  haptic::report::add_feel(app);
  haptic::report::add_bound(app);
  haptic::report::add_scaling(app);
  haptic::report::add_work_precision(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int status = app.exit(error);
    return status == 0 ? 0 : 2;
  } catch (const haptic::core::Error& error) {
    std::fprintf(stderr, "haptic-report: %s\n", error.what());
    return 2;
  }
  return 0;
}
