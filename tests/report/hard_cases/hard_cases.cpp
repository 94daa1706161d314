/// haptic-report hard-cases: core/METHOD.md#hard-cases.
#include <algorithm>
#include <cstdarg>
#include <cstdlib>

#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/hard_cases/hard_case.hpp"

namespace haptic::report {

std::string said(const char* format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

void add_hard_cases(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("hard-cases", "core/METHOD.md#hard-cases: case,expected,got,verdict");
  command->footer("Ends with 1 where a case did not pass.");
  command->callback([] {
    Outcomes all;
    kinematics_cases(all);
    renderer_cases(all);
    trajectory_cases(all);
    rank_cases(all);
    coupled_cases(all);
    reach_cases(all);
    loop_cases(all);
    prior_cases(all);
    energy_cases(all);
    sample_cases(all);
    std::stable_sort(all.begin(), all.end(), [](const Outcome& a, const Outcome& b) {
      return std::atoi(a.id.c_str()) < std::atoi(b.id.c_str());
    });
    row("case", "expected", "got", "verdict");
    for (const Outcome& one : all) {
      row(one.id, one.expected, one.got, one.passed ? "passed" : "failed");
    }
    if (!std::all_of(all.begin(), all.end(), [](const Outcome& one) { return one.passed; })) {
      throw FigureFailed{};
    }
  });
}

}  // namespace haptic::report
