#pragma once
/// Claims that must hold in the study rtt, and if they do.

#include <string>
#include <vector>

#include "tests/report/rtt_study.hpp"

namespace haptic::report {

struct RttRow {
  std::string object{};
  RttRun how{};
  RttFigures figures{};
  double energy_mj{0.0};
};

/// CSV: a line per claim with its limit, the worst row, and "met", "not met" or "not shown" (no
/// row). Throws SceneError: the file cannot be written.
void write_summary(const std::vector<RttRow>& rows, const std::string& file);

}  // namespace haptic::report
