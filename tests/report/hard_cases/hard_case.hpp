#pragma once
/// core/METHOD.md#hard-cases: the cases every implementation should pass.
/// Each adds one outcome; expected values come from that page or from algebra written out here.

#include <string>
#include <string_view>
#include <vector>

namespace haptic::report {

struct Outcome {
  std::string id{};
  std::string expected{};
  std::string got{};
  bool passed{false};
};
using Outcomes = std::vector<Outcome>;

/// printf to a string.
[[nodiscard]] [[gnu::format(printf, 1, 2)]] std::string said(const char* format, ...);

void kinematics_cases(Outcomes& out);  ///< 1, 2, 3
void renderer_cases(Outcomes& out);    ///< 4, 5, 6, 14
void trajectory_cases(Outcomes& out);  ///< 7, 8, 9, 19
void prior_cases(Outcomes& out);       ///< 9b, 25
void rank_cases(Outcomes& out);        ///< 10, 11, 12, 13
void coupled_cases(Outcomes& out);     ///< 13b
void reach_cases(Outcomes& out);       ///< 15, 16
void loop_cases(Outcomes& out);        ///< 17, 24, 26
void energy_cases(Outcomes& out);      ///< 18, 22, 23
void sample_cases(Outcomes& out);      ///< 20, 21

}  // namespace haptic::report
