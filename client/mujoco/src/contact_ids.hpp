#pragma once
/// Names of contacts that last from sample to sample.

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "vectors.hpp"

namespace haptic::mujoco {

/// The life of an id. It belongs to a pair of geoms and to one of the places where these meet: two
/// boxes meet in up to eight. A pair's contacts get the ids of those of the sample before that were
/// nearest on the tool, then ids of the pair that were out of use, then new ones. So a pair that
/// meets in one place has one id for ever, and an id that is not told comes back only for its pair.
class ContactIds {
 public:
  /// Begins a sample.
  void begin();
  /// `pair`: geoms, the smaller first. `on_tool`: the contact in the frame of the tool's geom, m.
  [[nodiscard]] std::uint32_t id(const std::pair<int, int>& pair, const Vector3& on_tool);

 private:
  struct Place {
    std::uint32_t id{0};
    Vector3 on_tool{};
    bool before{false}, now{false};  ///< told in the sample before; in this one
  };
  std::map<std::pair<int, int>, std::vector<Place>> pairs_{};
  std::uint32_t last_{0};
};

}  // namespace haptic::mujoco
