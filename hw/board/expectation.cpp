#include "hw/board/expectation.hpp"

#include <algorithm>
#include <sstream>

#include "haptic/core/model/finger_exoskeleton.hpp"

namespace haptic::hw::board {
namespace {

double milliseconds(core::Duration d) {
  return 1e3 * core::seconds(d);
}

bool names_a_linkage(const std::string& model) {
  const auto& all = core::kFingerLinkages;
  return std::find(all.begin(), all.end(), model) != all.end();
}

const char* unit_name(bool radian) {
  return radian ? "rad" : "m";
}

}  // namespace

std::string difference(const Expectation& expected, const Identity& found,
                       const std::optional<Identity>& before) {
  std::ostringstream text;
  const core::Duration watchdog = std::chrono::microseconds(found.watchdog_us);
  const auto changed = [&](const char* what, const auto& now, const auto& then) {
    text << "its " << what << " = " << now << ": must be " << then
         << ", as before the port was lost";
  };
  if (found.version != HB_PROTOCOL_VERSION) {
    text << "speaks version " << int{found.version} << " of the protocol; must be "
         << int{HB_PROTOCOL_VERSION};
  } else if (watchdog <= expected.longest_lateness || watchdog > kLongestWatchdog) {
    text << "its watchdog = " << milliseconds(watchdog)
         << " ms: must be longer than loop_late_fault, " << milliseconds(expected.longest_lateness)
         << " ms, and at most " << milliseconds(kLongestWatchdog) << " ms";
  } else if (!expected.serial.empty() && found.serial != expected.serial) {
    text << "its serial = '" << found.serial << "': must be '" << expected.serial << "'";
  } else if (!expected.linkage.empty() && found.model != expected.linkage &&
             names_a_linkage(found.model)) {
    text << "its model = '" << found.model << "': must be '" << expected.linkage
         << "', the linkage of the scene, or no linkage's name";
  } else if (before && found.serial != before->serial) {
    changed("serial", "'" + found.serial + "'", "'" + before->serial + "'");
  } else if (before && found.model != before->model) {
    changed("model", "'" + found.model + "'", "'" + before->model + "'");
  } else if (before && found.capabilities != before->capabilities) {
    changed("capabilities", int{found.capabilities}, int{before->capabilities});
  } else if (before && found.sample_period_us != before->sample_period_us) {
    changed("sample period", std::to_string(found.sample_period_us) + " us",
            std::to_string(before->sample_period_us) + " us");
  } else if (found.n_q != expected.dofs.size()) {
    text << "has " << int{found.n_q} << " DoF(s); must have " << expected.dofs.size();
  }
  return text.str();
}

std::string not_compared(const Expectation& expected, const Identity& found) {
  if (expected.linkage.empty() || found.model == expected.linkage) return {};
  return "does not say which linkage it carries (its model = '" + found.model +
         "'); the scene has " + expected.linkage;
}

std::string difference(const Expectation& expected, std::size_t index, const Dof& found) {
  const core::DofSpec& dof = expected.dofs[index];
  Eigen::Index a = 0;
  for (std::size_t i = 0; i < index; ++i) a += expected.dofs[i].actuated ? 1 : 0;
  const bool radian = dof.unit == core::Unit::kRadian;
  std::ostringstream text;
  if (found.name != dof.name) {
    text << "is called '" << found.name << "'; must be '" << dof.name << "'";
  } else if (found.radian != radian) {
    text << "is in " << unit_name(found.radian) << "; must be in " << unit_name(radian);
  } else if (found.actuated != dof.actuated) {
    text << (found.actuated ? "is actuated; must be sensed only"
                            : "is sensed only; must be actuated");
  } else if (dof.actuated && static_cast<double>(found.max_effort) < expected.max_effort[a]) {
    text << "max effort = " << found.max_effort << ": must be at least max_effort of the scene, "
         << expected.max_effort[a];
  } else {
    return {};
  }
  return "DoF " + std::to_string(index) + " " + text.str();
}

std::string difference_of_actuators(const Expectation& expected, const Identity& found) {
  const auto n_a = std::count_if(expected.dofs.begin(), expected.dofs.end(),
                                 [](const core::DofSpec& dof) { return dof.actuated; });
  if (found.n_a == n_a) return {};
  std::ostringstream text;
  text << "its n_a = " << int{found.n_a} << ": must be " << n_a
       << ", the actuated DoFs of its dictionary";
  return text.str();
}

}  // namespace haptic::hw::board
