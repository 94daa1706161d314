#pragma once
/// "device[0].impedance.stiffness_n_per_m[0]" as steps.

#include <string>
#include <vector>

namespace haptic::server {

struct FieldStep {
  std::string text{};      ///< as written: "device[0]"
  std::string name{};      ///< "device"
  int index{-1};           ///< -1: none given
  bool well_formed{true};  ///< of the form name or name[number]
};

/// At least one step, whatever the text. An index has at most six digits.
[[nodiscard]] std::vector<FieldStep> split_path(const std::string& path);

/// Is `inner` the field `outer` itself, or a field, element or message inside
/// of it?
[[nodiscard]] bool stands_within(const std::string& inner, const std::string& outer);

}  // namespace haptic::server
