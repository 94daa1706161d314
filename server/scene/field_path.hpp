#pragma once
/// "device[0].impedance.stiffness_n_per_m[0]" as steps.

#include <string>
#include <vector>

namespace haptic::server {

struct FieldStep {
  std::string name{};
  int index{-1};          ///< -1: none given
  bool malformed{false};  ///< not of the form name or name[number]
};

[[nodiscard]] inline std::vector<FieldStep> split_path(const std::string& path) {
  std::vector<FieldStep> steps;
  std::size_t from = 0;
  while (from <= path.size()) {
    const std::size_t dot = std::min(path.find('.', from), path.size());
    FieldStep step;
    step.name = path.substr(from, dot - from);
    const std::size_t bracket = step.name.find('[');
    if (bracket != std::string::npos) {
      const std::string digits = step.name.substr(bracket + 1);
      step.malformed = digits.size() < 2 || digits.size() > 6 || digits.back() != ']' ||
                       digits.find_first_not_of("0123456789") != digits.size() - 1;
      if (!step.malformed) step.index = std::stoi(digits);
      step.name.erase(bracket);
    }
    step.malformed = step.malformed || step.name.empty();
    steps.push_back(step);
    from = dot + 1;
  }
  return steps;
}

}  // namespace haptic::server
