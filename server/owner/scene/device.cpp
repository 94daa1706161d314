// One device of a scene.
#include <algorithm>

#include "hw/replay/tracked_orientation.hpp"
#include "server/owner/scene/parts.hpp"

namespace haptic::server {
namespace {

core::ThermalParameters read_thermal(const Part<v1::ThermalScene>& part) {
  core::ThermalParameters p;
  const auto required = [&](const char* name, bool given, double& value) {
    if (!given) return part.missing(name, "a number > 0");
    part.numbers({{name, &value, Allowed::kPositive}});
  };
  required("motor_constant", part->has_motor_constant(), p.motor_constant);
  required("winding_k_per_w", part->has_winding_k_per_w(), p.winding_resistance);
  required("winding_time_s", part->has_winding_time_s(), p.winding_time);
  required("limit_c", part->has_limit_c(), p.limit_c);
  part.numbers({{"housing_k_per_w", &p.housing_resistance, Allowed::kNotNegative},
                {"housing_time_s", &p.housing_time, Allowed::kPositive},
                {"ambient_c", &p.ambient_c, Allowed::kFinite}});
  p.derate_from_c = p.limit_c - 0.25 * (p.limit_c - p.ambient_c);
  part.numbers({{"derate_from_c", &p.derate_from_c, Allowed::kFinite}});
  if (!part.good()) return p;
  const std::string above = "must be above ambient_c, " + decimal(p.ambient_c);
  if (p.limit_c <= p.ambient_c) {
    part.wrong("limit_c", decimal(p.limit_c), above);
  } else if (p.derate_from_c <= p.ambient_c || p.derate_from_c >= p.limit_c) {
    part.wrong("derate_from_c", decimal(p.derate_from_c),
               above + ", and below limit_c, " + decimal(p.limit_c));
  }
  return p;
}

std::vector<core::ActuatorRatings> read_ratings(const Part<v1::LimitsScene>& part, int n_a) {
  const auto list_or_none = [&](const char* name) {
    return part.per_actuated(name, Allowed::kPositive, n_a, Fields::Numbers());
  };
  const Fields::Numbers power = list_or_none("power_w"), rate = list_or_none("rate_m_per_s");
  const auto thermals = part.parts<v1::ThermalScene>("thermal");
  const auto count = static_cast<int>(thermals.size());
  if (count != 0 && n_a >= 0 && count != n_a) {
    part.wrong("thermal", std::to_string(count) + " of them",
               "must be one per actuated DoF, " + std::to_string(n_a) + ", or none");
  }
  const auto entries = static_cast<std::size_t>(
      std::max({power.size(), rate.size(), static_cast<Eigen::Index>(count)}));
  std::vector<core::ActuatorRatings> ratings(entries);
  for (Eigen::Index i = 0; i < power.size(); ++i)
    ratings[static_cast<std::size_t>(i)].power = power[i];
  for (Eigen::Index i = 0; i < rate.size(); ++i)
    ratings[static_cast<std::size_t>(i)].rate = rate[i];
  for (std::size_t i = 0; i < thermals.size(); ++i) ratings[i].thermal = read_thermal(thermals[i]);
  return ratings;
}

/// The tracker gives the pose of the palm: needs a kinematics that has one.
void read_tracker(const Part<v1::StalenessScene>& part, DeviceScene& device) {
  core::TrackerSettings tracker;
  device.tracker_fresh_end = read_staleness(part, tracker.staleness);
  if (!device.pipeline.kinematics) return;
  // In q a palm is x, y, z and then its rotation vector (core, TrackedPalm).
  constexpr std::size_t kPosition = 3;
  const auto rotation = hw::rotation_vector_in(device.pipeline.kinematics->dofs());
  if (!rotation || *rotation < kPosition) {
    part.wrong("", "{ ... } with a device that has no tracked palm",
               "must go with tracked_hand, or with a serial_chain on a palm");
    return;
  }
  tracker.first_dof = static_cast<int>(*rotation - kPosition);
  device.pipeline.tracker = tracker;
}

}  // namespace

DeviceScene read_device(const Part<v1::DeviceScene>& part) {
  DeviceScene device;
  device.name = part->name();
  // The name is used in requests, log lines and health entries.
  if (!matches(part->name(), "[a-z0-9_-]{1,32}")) {
    part.wrong("name", quoted(part->name()), "must be 1 to 32 of [a-z0-9_-]");
  }
  core::PipelineConfig& pipeline = device.pipeline;
  pipeline.kinematics = read_kinematics(part);
  device.source = read_source(part, pipeline.kinematics.get());
  add_guard(part);
  read_rendering(part, device);
  if (part->has_limits()) {
    pipeline.ratings = read_ratings(part.part<v1::LimitsScene>("limits"), n_a_of(device));
  }
  pipeline.filter = read_filter(part);
  if (part->has_tracker()) read_tracker(part.part<v1::StalenessScene>("tracker"), device);
  if (part->has_force_control()) {
    read_force_control(part.part<v1::ForceControlScene>("force_control"), device);
  }
  add_tank(part, pipeline);
  if (part->has_passivity()) {
    read_passivity(part.part<v1::PassivityScene>("passivity"), device);
  }
  pipeline.derating = !part->has_unguarded();
  return device;
}

core::PipelineConfig pipeline_config(const DeviceScene& scene, const core::DeviceLimits& limits) {
  core::PipelineConfig config = scene.pipeline;
  config.device = limits;
  return config;
}

}  // namespace haptic::server
