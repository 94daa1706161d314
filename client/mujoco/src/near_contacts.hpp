#pragma once
/// MuJoCo's contacts of a tool, touched or near, as contacts of the client library.

#include <set>
#include <utility>
#include <vector>

#include "bound_tool.hpp"
#include "contact_ids.hpp"
#include "pushed_object.hpp"

namespace haptic::mujoco {

struct NearContact {
  client::Contact contact{};
  double force{0.0};  ///< normal, by MuJoCo, N
};

class NearContacts {
 public:
  explicit NearContacts(const BoundTool& tool) : tool_(&tool), surroundings_(tool) {}

  /// Notes the pairs that begin inside each other: they do not count until they were seen apart,
  /// because which side the tool came from is not known. The first time that there are such pairs
  /// mju_warning() says so.
  void begin(const mjModel& model, const mjData& data);
  /// The contacts that the last step found. `x`: all coordinates where the tool was then; `rate`:
  /// qvel then.
  [[nodiscard]] std::vector<NearContact> find(const mjModel& model, mjData& data,
                                              const std::vector<double>& x,
                                              const std::vector<mjtNum>& rate);

 private:
  [[nodiscard]] bool is_of_tool(const mjModel& model, const mjContact& contact) const;

  const BoundTool* tool_;
  Surroundings surroundings_;
  ContactIds ids_{};
  std::set<std::pair<int, int>> inside_{};
  bool warned_{false};
};

}  // namespace haptic::mujoco
