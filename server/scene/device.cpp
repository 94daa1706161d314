// One device of a scene.
#include <algorithm>

#include "hw/replay/tracked_orientation.hpp"
#include "server/scene/parts.hpp"
#include "server/scene/reader.hpp"

namespace haptic::server {
namespace {

/// The name is used in requests, log lines and health entries.
void check_name(const std::string& name, const std::string& path, Problems& problems) {
  const bool well_formed =
      !name.empty() && name.size() <= 32 &&
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_-") == std::string::npos;
  if (!well_formed) problems.wrong(path + ".name", quoted(name), "must be 1 to 32 of [a-z0-9_-]");
}

/// A list that may be absent.
std::vector<double> list_or_none(const FieldReader& reader, const char* name, int given, int n_a) {
  if (given == 0) return {};
  return reader.list({name, Allowed::kPositive, n_a, kPerActuatedDof});
}

core::ThermalParameters read_thermal(v1::ThermalScene& message, const std::string& path,
                                     Problems& problems) {
  const FieldReader reader(message, path, problems);
  core::ThermalParameters p;
  const std::size_t before = problems.count();
  const auto required = [&](const char* name, bool given, double& value) {
    if (!given) return problems.missing(path + "." + name, "a number > 0");
    reader.numbers({{name, &value, Allowed::kPositive}});
  };
  required("motor_constant", message.has_motor_constant(), p.motor_constant);
  required("winding_k_per_w", message.has_winding_k_per_w(), p.winding_resistance);
  required("winding_time_s", message.has_winding_time_s(), p.winding_time);
  required("limit_c", message.has_limit_c(), p.limit_c);
  reader.numbers({{"housing_k_per_w", &p.housing_resistance, Allowed::kNotNegative},
                  {"housing_time_s", &p.housing_time, Allowed::kPositive},
                  {"ambient_c", &p.ambient_c, Allowed::kFinite}});
  p.derate_from_c = p.limit_c - 0.25 * (p.limit_c - p.ambient_c);
  reader.numbers({{"derate_from_c", &p.derate_from_c, Allowed::kFinite}});
  if (problems.count() > before) return p;
  if (p.limit_c <= p.ambient_c) {
    reader.wrong("limit_c", decimal(p.limit_c), "must be above ambient_c, " + decimal(p.ambient_c));
  } else if (p.derate_from_c <= p.ambient_c || p.derate_from_c >= p.limit_c) {
    reader.wrong("derate_from_c", decimal(p.derate_from_c),
                 "must be above ambient_c, " + decimal(p.ambient_c) + ", and below limit_c, " +
                     decimal(p.limit_c));
  }
  return p;
}

std::vector<core::ActuatorRatings> read_ratings(v1::LimitsScene& message, const std::string& path,
                                                int n_a, Problems& problems) {
  const FieldReader reader(message, path, problems);
  const auto power = list_or_none(reader, "power_w", message.power_w_size(), n_a);
  const auto rate = list_or_none(reader, "rate_m_per_s", message.rate_m_per_s_size(), n_a);
  const int thermals = message.thermal_size();
  if (thermals != 0 && n_a >= 0 && thermals != n_a) {
    reader.wrong("thermal", std::to_string(thermals) + " of them",
                 "must be one per actuated DoF, " + std::to_string(n_a) + ", or none");
  }
  const auto entries = static_cast<std::size_t>(
      std::max({static_cast<int>(power.size()), static_cast<int>(rate.size()), thermals}));
  std::vector<core::ActuatorRatings> ratings(entries);
  for (std::size_t i = 0; i < entries; ++i) {
    if (i < power.size()) ratings[i].power = power[i];
    if (i < rate.size()) ratings[i].rate = rate[i];
    if (static_cast<int>(i) >= thermals) continue;
    ratings[i].thermal = read_thermal(*message.mutable_thermal(static_cast<int>(i)),
                                      path + "." + entry("thermal", i), problems);
  }
  return ratings;
}

double read_coupling_metric(v1::CouplingMetricScene& message, const std::string& path,
                            Problems& problems) {
  const FieldReader reader(message, path, problems);
  double softness = 0.01;  // core/METHOD.md#anisotropic-coupling
  reader.numbers({{"softness", &softness, Allowed::kPositive}});
  if (softness > 1.0) reader.wrong("softness", decimal(softness), "must be at most 1");
  return softness;
}

/// The tracker gives the pose of the palm: needs a kinematics that has one.
void read_tracker(v1::StalenessScene& message, const std::string& path, DeviceScene& device,
                  Problems& problems) {
  core::TrackerSettings tracker;
  device.tracker_fresh_end = read_staleness(message, path, tracker.staleness, problems);
  if (!device.pipeline.kinematics) return;
  // In q a palm is x, y, z and then its rotation vector (core, TrackedPalm).
  constexpr std::size_t kPosition = 3;
  const auto rotation = hw::rotation_vector_in(device.pipeline.kinematics->dofs());
  if (!rotation || *rotation < kPosition) {
    problems.wrong(path, "{ ... } with a device that has no tracked palm",
                   "must go with tracked_hand, or with a serial_chain on a palm");
    return;
  }
  tracker.first_dof = static_cast<int>(*rotation - kPosition);
  device.pipeline.tracker = tracker;
}

}  // namespace

DeviceScene read_device(v1::DeviceScene& message, const std::string& path,
                        const std::filesystem::path& folder, Problems& problems) {
  check_name(message.name(), path, problems);
  DeviceScene device;
  device.name = message.name();
  core::PipelineConfig& pipeline = device.pipeline;
  pipeline.kinematics = read_kinematics(message, path, problems);
  const core::Kinematics* kinematics = pipeline.kinematics.get();
  device.source = read_source(message, path, folder, kinematics, problems);
  read_rendering(message, path, device, problems);
  if (message.has_limits()) {
    pipeline.ratings =
        read_ratings(*message.mutable_limits(), path + ".limits", n_a_of(kinematics), problems);
  }
  if (message.has_tracker()) {
    read_tracker(*message.mutable_tracker(), path + ".tracker", device, problems);
  }
  if (message.has_force_control()) {
    read_force_control(*message.mutable_force_control(), path + ".force_control", device, problems);
  }
  if (message.has_passivity()) {
    read_passivity(*message.mutable_passivity(), path + ".passivity", device, problems);
  }
  pipeline.passivity_certificate = message.has_passivity_certificate();
  if (message.has_passivity_certificate() && message.has_prior()) {
    problems.wrong(path + ".passivity_certificate", "{}",
                   "must be absent where there is a prior: it speaks of Eq. (8) without one");
  }
  if (message.has_coupling_metric()) {
    device.coupling_softness = read_coupling_metric(*message.mutable_coupling_metric(),
                                                    path + ".coupling_metric", problems);
  }
  return device;
}

core::PipelineConfig pipeline_config(const DeviceScene& scene, const core::DeviceLimits& limits) {
  core::PipelineConfig config = scene.pipeline;
  config.device = limits;
  return config;
}

}  // namespace haptic::server
