// Who closes the loop on the measured force of a device.
#include <algorithm>
#include <functional>

#include "haptic/core/error.hpp"
#include "server/scene/parts.hpp"
#include "server/scene/reader.hpp"

namespace haptic::server {
namespace {

std::vector<double> constant(int n_a, double value) {
  std::vector<double> values(static_cast<std::size_t>(std::max(n_a, 0)), value);
  return values;
}

bool same_size(std::initializer_list<std::size_t> sizes) {
  return std::adjacent_find(sizes.begin(), sizes.end(), std::not_equal_to<>{}) == sizes.end();
}

/// The force limit and the friction on top, as far as the device can give it.
std::vector<double> default_output(const core::VecA& force_limit, const core::VecA& max_effort,
                                   const std::vector<double>& friction) {
  std::vector<double> output;
  if (force_limit.size() != max_effort.size()) return output;
  for (Eigen::Index i = 0; i < force_limit.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double added = k < friction.size() ? friction[k] : 0.0;
    output.push_back(std::min(force_limit[i] + added, max_effort[i]));
  }
  return output;
}

std::vector<core::ForceLoopGains> read_server(v1::ServerForceLoopScene& message,
                                              const std::string& path, int n_a,
                                              const core::VecA& force_limit,
                                              const core::VecA& max_effort, Problems& problems) {
  const FieldReader reader(message, path, problems);
  const auto proportional =
      reader.list({"proportional", Allowed::kNotNegative, n_a, kPerActuatedDof});
  const auto integral =
      reader.list({"integral_per_s", Allowed::kNotNegative, n_a, kPerActuatedDof});
  const auto friction =
      reader.list({"friction_n", Allowed::kNotNegative, n_a, kPerActuatedDof}, constant(n_a, 0.0));
  const auto band = reader.list({"friction_band_n", Allowed::kPositive, n_a, kPerActuatedDof},
                                constant(n_a, 1.0));
  const auto output = reader.list({"output_limit_n", Allowed::kPositive, n_a, kPerActuatedDof},
                                  default_output(force_limit, max_effort, friction));
  if (!same_size(
          {proportional.size(), integral.size(), friction.size(), band.size(), output.size()})) {
    return {};  // reported
  }
  std::vector<core::ForceLoopGains> loops;
  for (std::size_t i = 0; i < proportional.size(); ++i) {
    loops.push_back({proportional[i], integral[i], friction[i], band[i], output[i]});
    const auto a = static_cast<Eigen::Index>(i);
    if (a < max_effort.size() && output[i] > max_effort[a]) {
      reader.wrong("output_limit_n[" + std::to_string(i) + "]", decimal(output[i]),
                   "must be at most what the device can give, " + decimal(max_effort[a]));
    }
  }
  return loops;
}

/// Where an actuated DoF may be sent, and what says so.
struct Travel {
  double lower{0.0}, upper{0.0};
  const char* whose{"the DoF's own"};
};

/// Beyond the calibrated travel a valid sample ends: an admittance must not lead there.
std::vector<Travel> travels(const core::Kinematics* kinematics, const hw::DeviceConfig* source) {
  const std::optional<hw::Travel> calibrated = source == nullptr ? std::nullopt : source->travel();
  std::vector<Travel> all;
  const int n_a = kinematics == nullptr ? 0 : kinematics->layout().n_a();
  for (int i = 0; i < n_a; ++i) {
    const int dof = kinematics->layout().actuated(i);
    const core::DofSpec& spec = kinematics->dofs()[static_cast<std::size_t>(dof)];
    all.push_back({spec.lower, spec.upper});
    if (!calibrated) continue;
    all.back() = {std::max(spec.lower, calibrated->lower[dof]),
                  std::min(spec.upper, calibrated->upper[dof]), "the calibrated travel's"};
  }
  return all;
}

std::vector<core::AdmittanceParameters> read_admittance(v1::AdmittanceScene& message,
                                                        const std::string& path,
                                                        const core::Kinematics* kinematics,
                                                        const hw::DeviceConfig* source,
                                                        Problems& problems) {
  const FieldReader reader(message, path, problems);
  const int n_a = n_a_of(kinematics);
  std::vector<double> stroke_begin, stroke_end;
  const std::vector<Travel> travel = travels(kinematics, source);
  for (const Travel& each : travel) {
    stroke_begin.push_back(each.lower);
    stroke_end.push_back(each.upper);
  }
  const auto mass =
      reader.list({"mass_kg", Allowed::kNotNegative, n_a, kPerActuatedDof}, constant(n_a, 0.0));
  const auto damping = reader.list({"damping_n_s_per_m", Allowed::kPositive, n_a, kPerActuatedDof});
  const auto rate = reader.list({"max_rate_m_per_s", Allowed::kPositive, n_a, kPerActuatedDof});
  const auto lower = reader.list({"lower", Allowed::kFinite, n_a, kPerActuatedDof}, stroke_begin);
  const auto upper = reader.list({"upper", Allowed::kFinite, n_a, kPerActuatedDof}, stroke_end);
  if (!same_size({mass.size(), damping.size(), rate.size(), lower.size(), upper.size()})) return {};
  std::vector<core::AdmittanceParameters> admittances;
  for (std::size_t i = 0; i < mass.size(); ++i) {
    admittances.push_back({mass[i], damping[i], rate[i], lower[i], upper[i]});
    if (i >= stroke_begin.size()) continue;
    const std::string at = "[" + std::to_string(i) + "]";
    if (lower[i] < stroke_begin[i]) {
      reader.wrong(
          "lower" + at, decimal(lower[i]),
          std::string("must be at least ") + travel[i].whose + ", " + decimal(stroke_begin[i]));
    } else if (upper[i] > stroke_end[i]) {
      reader.wrong(
          "upper" + at, decimal(upper[i]),
          std::string("must be at most ") + travel[i].whose + ", " + decimal(stroke_end[i]));
    } else if (lower[i] >= upper[i]) {
      reader.wrong("lower" + at, decimal(lower[i]), "must be below upper, " + decimal(upper[i]));
    }
  }
  return admittances;
}

}  // namespace

void read_force_control(v1::ForceControlScene& message, const std::string& path,
                        DeviceScene& device, Problems& problems) {
  const core::Kinematics* kinematics = device.pipeline.kinematics.get();
  const hw::DeviceConfig* source = device.source.get();
  if (source != nullptr && !source->may_measure_force()) {
    problems.wrong(path, "{ ... }", "must go with board: nothing else measures its force");
  }
  core::ForceControlSettings& settings = device.pipeline.force_control;
  switch (message.where_case()) {
    case v1::ForceControlScene::kBoard:
      device.force_control = ForceControlPlace::kBoard;
      break;
    case v1::ForceControlScene::kServer:
      settings.loops = read_server(*message.mutable_server(), path + ".server", n_a_of(kinematics),
                                   device.pipeline.scene.force_limit,
                                   source == nullptr ? core::VecA{} : source->effort(), problems);
      device.force_control = ForceControlPlace::kServer;
      break;
    case v1::ForceControlScene::kAdmittance:
      settings.admittances = read_admittance(*message.mutable_admittance(), path + ".admittance",
                                             kinematics, source, problems);
      device.force_control = ForceControlPlace::kAdmittance;
      break;
    case v1::ForceControlScene::WHERE_NOT_SET:
      problems.missing(path + ".where", "one of board, server, admittance");
      break;
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
              "admittance, where it measures force");
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
