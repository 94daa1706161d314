#pragma once
/// The fields of planes and contacts, but for the normal and the geometry: made of the messages
/// (proto/generate).

#include <algorithm>
#include <string>
#include <vector>

#include "haptic/client/contact.hpp"
#include "structs.hpp"

namespace haptic::c {

void read_fields(const haptic_plane& from, client::Plane& to);
void read_fields(const haptic_contact& from, client::Contact& to);
void write_fields(const client::Plane& from, haptic_plane& to);

/// Refuses a list that has no room; returns its size.
template <std::size_t kSize>
std::uint32_t write_values(const std::vector<double>& values, double (&to)[kSize]) {
  if (values.size() > kSize) {
    refuse("a list of " + std::to_string(values.size()) + " numbers, must be at most " +
           std::to_string(kSize));
  }
  std::copy(values.begin(), values.end(), to);
  return static_cast<std::uint32_t>(values.size());
}

inline void at_most(const char* name, std::uint32_t count, std::size_t most) {
  if (count > most) {
    refuse(std::string(name) + " = " + std::to_string(count) + ", must be at most " +
           std::to_string(most));
  }
}

}  // namespace haptic::c
