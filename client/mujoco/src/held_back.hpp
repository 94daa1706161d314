#pragma once
/// Tells people if the force that is told is not the one that holds the tool back.

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "aim.hpp"
#include "bound_tool.hpp"
#include "coupling.hpp"

namespace haptic::mujoco {

class HeldBack {
 public:
  HeldBack(const BoundTool& tool, const Coupling& coupling, const Aim& aim)
      : tool_(&tool), coupling_(&coupling), aim_(&aim) {}
  void restart();

  /// A sample, after mj_step. `told`: the contacts' force that is told, N or N m per coordinate. A
  /// second's mean of it is compared with that of the coupling's springs less what moved masses
  /// take, the first time after 0.2 s. Warns if they differ by more than 2 %, once of each contact.
  void look(const mjModel& model, const mjData& data, std::vector<double> told);

 private:
  /// Leaves out what is not known: turns, and positions while a point or pose moves.
  void leave_out(std::vector<double>& told, std::vector<double>& pulled);
  void compare(const mjModel& model, const mjData& data);

  const BoundTool* tool_;
  const Coupling* coupling_;
  const Aim* aim_;
  std::vector<double> told_{}, held_{};  ///< sums over samples
  double rested_{0.0};                   ///< for how long all points and poses are to rest, s
  double samples_{0.0}, left_{0.0};      ///< left: s
  std::set<std::string> said_{};
};

}  // namespace haptic::mujoco
