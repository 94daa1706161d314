// Who closes the loop on the measured force of a device.
#include <algorithm>

#include "haptic/core/error.hpp"
#include "server/owner/scene/parts.hpp"

namespace haptic::server {
namespace {

/// Range of a load cell over the device's max_effort. If a hand pushes a geared drive back, the
/// cell reads the drive's force and its friction, which may be as large.
constexpr double kRangePerEffort = 2.0;

/// Growth of a true reading per second over max_effort: 10 ms from 0 to it. A rod that strikes
/// takes longer (core/METHOD.md#a-load-cell-that-lies).
constexpr double kRatePerEffort = 100.0;

/// Belief of both laws about a load cell: its range, rate and `stuck`, how far the command may move
/// while the cell stands still.
std::vector<core::CellRatings> read_cells(const Fields& part, int n_a, const core::VecA& effort,
                                          const char* stuck, const core::VecA& swing_by_default) {
  std::vector<core::CellRatings> cells;
  if (effort.size() != n_a || swing_by_default.size() != n_a) return cells;  // reported
  const auto list = [&](const char* name, const Fields::Numbers& fallback) {
    return part.per_actuated(name, Allowed::kPositive, n_a, fallback);
  };
  const Fields::Numbers range = list("cell_range_n", Fields::Numbers(kRangePerEffort * effort));
  const Fields::Numbers rate = list("cell_rate_n_per_s", Fields::Numbers(kRatePerEffort * effort));
  const Fields::Numbers swing = list(stuck, swing_by_default);
  if (!part.good()) return cells;
  for (Eigen::Index i = 0; i < n_a; ++i) {
    cells.push_back({.range = range[i], .rate = rate[i], .swing = swing[i]});
  }
  return cells;
}

/// The same for a force loop, whose drive is known too.
std::vector<core::CellRatings> read_cells(const Part<v1::ServerForceLoopScene>& part, int n_a,
                                          const core::VecA& effort) {
  std::vector<core::CellRatings> cells = read_cells(part, n_a, effort, "stuck_n", 0.1 * effort);
  if (cells.empty()) return cells;
  const Fields::Numbers fed =
      part.per_actuated("friction_n", Allowed::kNotNegative, n_a, filled(n_a, 0.0));
  const Fields::Numbers friction = part.per_actuated("drive_friction_n", Allowed::kPositive, n_a,
                                                     Fields::Numbers(2.0 * fed + 0.25 * effort));
  Fields::Numbers damping;
  if (part->drive_damping_n_s_per_m_size() > 0) {
    damping = part.per_actuated("drive_damping_n_s_per_m", Allowed::kNotNegative, n_a);
  }
  if (!part.good()) return cells;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const auto a = static_cast<Eigen::Index>(i);
    cells[i].friction = friction[a];
    if (damping.size() > 0) cells[i].damping = damping[a];
  }
  return cells;
}

std::vector<core::ForceLoopGains> read_server(const Part<v1::ServerForceLoopScene>& part, int n_a,
                                              const core::VecA& force_limit,
                                              const core::VecA& effort) {
  const auto list = [&](const char* name, Allowed allowed,
                        const std::optional<Fields::Numbers>& fallback = {}) {
    return part.per_actuated(name, allowed, n_a, fallback);
  };
  const auto proportional = list("proportional", Allowed::kNotNegative);
  const auto integral = list("integral_per_s", Allowed::kNotNegative);
  const auto friction = list("friction_n", Allowed::kNotNegative, filled(n_a, 0.0));
  const auto band = list("friction_band_n", Allowed::kPositive, filled(n_a, 1.0));
  // The force limit and the friction on top, as far as the device can give it.
  Fields::Numbers most;
  if (force_limit.size() == effort.size() && friction.size() == effort.size()) {
    most = (force_limit + friction).cwiseMin(effort);
  }
  const auto output = list("output_limit_n", Allowed::kPositive, most);
  std::vector<core::ForceLoopGains> loops;
  if (!part.good() || output.size() != n_a) return loops;
  for (Eigen::Index i = 0; i < n_a; ++i) {
    loops.push_back({proportional[i], integral[i], friction[i], band[i], output[i]});
  }
  check_within_effort(part, "output_limit_n", output, effort);
  return loops;
}

/// Where the actuated DoFs may be sent, n_a each, and what says so. Beyond the calibrated travel a
/// valid sample ends: an admittance must not lead there.
struct Travel {
  explicit Travel(const DeviceScene& device) : lower(filled(n_a_of(device), 0.0)), upper(lower) {
    if (!device.pipeline.kinematics) return;
    const core::Kinematics& kinematics = *device.pipeline.kinematics;
    const core::DofLayout& layout = kinematics.layout();
    for (int i = 0; i < layout.n_a(); ++i) {
      const auto dof = static_cast<std::size_t>(layout.actuated(i));
      lower[i] = kinematics.dofs()[dof].lower;
      upper[i] = kinematics.dofs()[dof].upper;
    }
    const auto calibrated = device.source ? device.source->travel() : std::nullopt;
    if (!calibrated) return;
    lower = lower.cwiseMax(layout.select(calibrated->lower));
    upper = upper.cwiseMin(layout.select(calibrated->upper));
    whose = "the calibrated travel's, ";
  }

  Fields::Numbers lower, upper;
  std::string whose{"the DoF's own, "};
};

std::vector<core::AdmittanceParameters> read_admittance(const Part<v1::AdmittanceScene>& part,
                                                        const DeviceScene& device) {
  const int n_a = n_a_of(device);
  const Travel travel(device);
  const auto mass = part.per_actuated("mass_kg", Allowed::kNotNegative, n_a, filled(n_a, 0.0));
  const auto damping = part.per_actuated("damping_n_s_per_m", Allowed::kPositive, n_a);
  const auto rate = part.per_actuated("max_rate_m_per_s", Allowed::kPositive, n_a);
  const auto lower = part.per_actuated("lower", Allowed::kFinite, n_a, travel.lower);
  const auto upper = part.per_actuated("upper", Allowed::kFinite, n_a, travel.upper);
  std::vector<core::AdmittanceParameters> admittances;
  if (!part.good()) return admittances;
  for (Eigen::Index i = 0; i < n_a; ++i) {
    const auto k = static_cast<std::size_t>(i);
    admittances.push_back({mass[i], damping[i], rate[i], lower[i], upper[i]});
    if (lower[i] < travel.lower[i]) {
      part.wrong({"lower", k}, decimal(lower[i]),
                 "must be at least " + travel.whose + decimal(travel.lower[i]));
    } else if (upper[i] > travel.upper[i]) {
      part.wrong({"upper", k}, decimal(upper[i]),
                 "must be at most " + travel.whose + decimal(travel.upper[i]));
    } else if (lower[i] >= upper[i]) {
      part.wrong({"lower", k}, decimal(lower[i]), "must be below upper, " + decimal(upper[i]));
    }
  }
  return admittances;
}

}  // namespace

void read_force_control(const Part<v1::ForceControlScene>& part, DeviceScene& device) {
  if (device.source && !device.source->may_measure_force()) {
    part.wrong("", "{ ... }", "must go with board: nothing else measures its force");
  }
  core::ForceControlSettings& settings = device.pipeline.force_control;
  const std::string where = part.choice("where");
  if (where == "board") device.force_control = ForceControlPlace::kBoard;
  if (where == "server") {
    device.force_control = ForceControlPlace::kServer;
    const auto loop = part.part<v1::ServerForceLoopScene>(where);
    const core::VecA effort = effort_of(device);
    settings.loops = read_server(loop, n_a_of(device), device.pipeline.scene.force_limit, effort);
    if (part.good()) settings.cells = read_cells(loop, n_a_of(device), effort);
  }
  if (where == "admittance") {
    device.force_control = ForceControlPlace::kAdmittance;
    const auto law = part.part<v1::AdmittanceScene>(where);
    settings.admittances = read_admittance(law, device);
    core::VecA travel(static_cast<Eigen::Index>(settings.admittances.size()));
    for (Eigen::Index i = 0; i < travel.size(); ++i) {
      const core::AdmittanceParameters& p = settings.admittances[static_cast<std::size_t>(i)];
      travel[i] = p.upper - p.lower;
    }
    if (part.good()) {
      settings.cells = read_cells(law, n_a_of(device), effort_of(device), "stuck_m", 0.1 * travel);
    }
  }
}

void check_force_control(ForceControlPlace place, const hw::DeviceInfo& device) {
  const auto require = [](bool holds, const std::string& what) {
    if (!holds) throw core::DeviceError("force_control: " + what);
  };
  switch (place) {
    case ForceControlPlace::kAny:
      return;
    case ForceControlPlace::kBoard:
      require(device.closes_force_loop,
              "board {}: this device does not close the loop on its force; must be server or "
              "admittance, if it measures force");
      return;
    case ForceControlPlace::kServer:
      require(device.measures_force, "server {}: this device measures no force");
      require(
          !device.closes_force_loop,
          "server {}: this device closes the loop itself, and two loops in a row fight; must be "
          "board {}");
      return;
    case ForceControlPlace::kAdmittance:
      require(device.measures_force, "admittance {}: this device measures no force");
      require(device.takes_positions, "admittance {}: this device does not take positions");
      return;
  }
}

}  // namespace haptic::server
