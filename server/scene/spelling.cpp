#include "server/scene/spelling.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace haptic::server {
namespace {

/// Levenshtein's distance: the fewest letters to insert, delete or replace.
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

/// Letters of `wanted` that would have to go to make it a beginning of `name`:
/// "stiffness" stands nearer to "stiffness_n_per_m" than its unit would have
/// it.
std::size_t unlikeness(const std::string& name, const std::string& wanted) {
  return std::min(2 * distance(name, wanted),
                  2 * distance(name.substr(0, wanted.size()), wanted) + 1);
}

constexpr std::size_t kLongestSpelt = 64;  // beyond, nobody misspelt anything

}  // namespace

std::string fields_of(const google::protobuf::Descriptor& type, const std::string& wanted) {
  const std::string name = wanted.substr(0, kLongestSpelt);
  std::vector<std::pair<std::size_t, std::string>> fields;
  for (int i = 0; i < type.field_count(); ++i) {
    const std::string& field = type.field(i)->name();
    fields.emplace_back(unlikeness(field, name), field);
  }
  std::stable_sort(fields.begin(), fields.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::string all;
  for (const auto& [likeness, field] : fields) all += (all.empty() ? "" : ", ") + field;
  return all.empty() ? "no fields" : all;
}

}  // namespace haptic::server
