#include "server/scene/field_path.hpp"

#include <algorithm>
#include <cctype>

namespace haptic::server {
namespace {

FieldStep step_of(const std::string& text) {
  FieldStep step{text, text.substr(0, text.find('[')), -1, true};
  step.well_formed = !step.name.empty() &&
                     std::all_of(step.name.begin(), step.name.end(),
                                 [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; });
  if (step.name.size() == text.size()) return step;
  const std::string index = text.substr(step.name.size() + 1);
  const bool number = index.size() >= 2 && index.size() <= 7 && index.back() == ']' &&
                      index.find_first_not_of("0123456789") == index.size() - 1;
  if (number) {
    step.index = std::stoi(index);
  } else {
    step.well_formed = false;
  }
  return step;
}

}  // namespace

std::vector<FieldStep> split_path(const std::string& path) {
  std::vector<FieldStep> steps;
  for (std::size_t from = 0; from <= path.size();) {
    const std::size_t dot = std::min(path.find('.', from), path.size());
    steps.push_back(step_of(path.substr(from, dot - from)));
    from = dot + 1;
  }
  return steps;
}

bool stands_within(const std::string& inner, const std::string& outer) {
  if (inner.compare(0, outer.size(), outer) != 0) return false;
  return inner.size() == outer.size() || inner[outer.size()] == '.' || inner[outer.size()] == '[';
}

}  // namespace haptic::server
