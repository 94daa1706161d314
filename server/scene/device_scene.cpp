#include "server/scene/device_scene.hpp"

#include <algorithm>
#include <cmath>

#include "server/scene/finger_fields.hpp"
#include "server/scene/number_table.hpp"

namespace haptic::server {

namespace {

using google::protobuf::RepeatedField;

constexpr double kSlewPerForce = 100.0;  // full force in 10 ms
constexpr double kEngageWindowPerForce = 0.25;

std::string index(const std::string& path, int i) {
  return path + "[" + std::to_string(i) + "]";
}

void check_name(const v1::DeviceScene& message, const std::string& path, Problems& problems) {
  const std::string& name = message.name();
  const bool good =
      !name.empty() && name.size() <= 32 &&
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_-") == std::string::npos;
  if (!good) problems.add(path + ".name", "\"" + name + "\"", "must be 1 to 32 of a-z 0-9 _ -");
}

std::filesystem::path resolved(const std::string& file, const std::filesystem::path& folder) {
  const std::filesystem::path path(file);
  return path.is_absolute() ? path : folder / path;
}

/// Fills a list of one value per DoF with `value` where it is empty.
void fill(RepeatedField<double>& list, int count, double value) {
  if (!list.empty()) return;
  for (int i = 0; i < count; ++i) list.Add(value);
}

hw::SimulatedFingerConfig read_simulated_finger(v1::SimulatedFinger& scene, const std::string& path,
                                                const std::filesystem::path& folder,
                                                Problems& problems) {
  hw::SimulatedFingerConfig config;
  read_numbers(scene, path, kSimulatedFields, config, problems);
  if (config.actuator_force_limit <= 0.0) {
    problems.add(path + ".actuator_force_limit_n", config.actuator_force_limit, "must be > 0");
  }
  if (!scene.has_seed()) scene.set_seed(config.seed);
  config.seed = scene.seed();
  if (!scene.motion_file().empty()) {
    config.motion_file = resolved(scene.motion_file(), folder);
    scene.set_motion_file(config.motion_file.string());
    if (!std::filesystem::is_regular_file(config.motion_file)) {
      problems.add(path + ".motion_file", "\"" + config.motion_file.string() + "\"",
                   "must be a CSV file that exists");
    }
  }
  return config;
}

hw::SimulatedLinearConfig read_simulated_linear(v1::SimulatedLinear& scene, const std::string& path,
                                                int n_q, int n_a, Problems& problems) {
  fill(*scene.mutable_damping(), n_q, 0.0);
  fill(*scene.mutable_hand_stiffness(), n_q, 0.0);
  fill(*scene.mutable_hand_damping(), n_q, 0.0);
  fill(*scene.mutable_target(), n_q, 0.0);
  hw::SimulatedLinearConfig config;
  const auto per_dof = [&](const RepeatedField<double>& field, const char* name, double lowest,
                           bool lowest_allowed) {
    return read_list(field, n_q, path + "." + name, "DoF", lowest, lowest_allowed, problems);
  };
  config.mass = per_dof(scene.mass(), "mass", 0.0, false);
  config.damping = per_dof(scene.damping(), "damping", 0.0, true);
  config.hand_stiffness = per_dof(scene.hand_stiffness(), "hand_stiffness", 0.0, true);
  config.hand_damping = per_dof(scene.hand_damping(), "hand_damping", 0.0, true);
  config.target = per_dof(scene.target(), "target", kAny, true);
  config.max_effort = read_list(scene.max_effort(), n_a, path + ".max_effort", "actuated DoF", 0.0,
                                false, problems);
  return config;
}

/// The source, and the largest effort of each actuated DoF.
core::VecA read_source(v1::DeviceScene& message, const std::string& path,
                       const std::filesystem::path& folder, const core::Kinematics& kinematics,
                       hw::DeviceConfig& source, Problems& problems) {
  const int n_q = kinematics.layout().n_q(), n_a = kinematics.layout().n_a();
  switch (message.source_case()) {
    case v1::DeviceScene::kSimulatedFinger: {
      if (!message.has_finger_exoskeleton()) {
        problems.add(path + ".simulated_finger", "with another map",
                     "needs kinematics finger_exoskeleton");
      }
      const auto config = read_simulated_finger(*message.mutable_simulated_finger(),
                                                path + ".simulated_finger", folder, problems);
      source = config;
      return core::VecA::Constant(1, config.actuator_force_limit);
    }
    case v1::DeviceScene::kSimulatedLinear: {
      if (!message.has_linear()) {
        problems.add(path + ".simulated_linear", "with another map", "needs kinematics linear");
      }
      const auto config = read_simulated_linear(*message.mutable_simulated_linear(),
                                                path + ".simulated_linear", n_q, n_a, problems);
      source = config;
      return config.max_effort;
    }
    case v1::DeviceScene::kReplay: {
      v1::Replay& replay = *message.mutable_replay();
      hw::ReplayConfig config;
      config.file = resolved(replay.file(), folder);
      config.repeat = replay.repeat();
      if (replay.file().empty() || !std::filesystem::is_regular_file(config.file)) {
        problems.add(path + ".replay.file", "\"" + config.file.string() + "\"",
                     "must be a CSV file that exists");
      }
      replay.set_file(config.file.string());
      config.max_effort = read_list(replay.max_effort(), n_a, path + ".replay.max_effort",
                                    "actuated DoF", 0.0, false, problems);
      source = config;
      return config.max_effort;
    }
    case v1::DeviceScene::SOURCE_NOT_SET:
      problems.missing(path + ".source",
                       "must be one of simulated_finger, simulated_linear, replay");
  }
  return {};
}

core::RendererKind read_renderer(v1::DeviceScene& message) {
  switch (message.renderer_case()) {
    case v1::DeviceScene::kStandard:
      return core::RendererKind::kStandard;
    case v1::DeviceScene::kNullSpace:
      return core::RendererKind::kNullSpace;
    case v1::DeviceScene::kSubspaceExact:
      return core::RendererKind::kSubspaceExact;
    default:
      break;
  }
  message.mutable_subspace_linear();
  return core::RendererKind::kSubspaceLinear;
}

void read_limits(v1::DeviceScene& message, const std::string& path, int n_a,
                 const core::VecA& max_effort, core::RenderSettings& settings, Problems& problems) {
  const std::string per = "actuated DoF";
  if (!message.has_impedance()) problems.missing(path + ".impedance", "must be given");
  v1::ImpedanceScene& impedance = *message.mutable_impedance();
  fill(*impedance.mutable_damping_n_s_per_m(), n_a, 0.0);
  settings.stiffness = read_list(impedance.stiffness_n_per_m(), n_a,
                                 path + ".impedance.stiffness_n_per_m", per, 0.0, false, problems);
  settings.damping = read_list(impedance.damping_n_s_per_m(), n_a,
                               path + ".impedance.damping_n_s_per_m", per, 0.0, true, problems);

  if (!message.has_limits()) problems.missing(path + ".limits", "must be given");
  v1::LimitsScene& limits = *message.mutable_limits();
  settings.force_limit =
      read_list(limits.force_n(), n_a, path + ".limits.force_n", per, 0.0, false, problems);
  if (limits.slew_n_per_s().empty()) {
    for (const double force : limits.force_n()) limits.add_slew_n_per_s(kSlewPerForce * force);
  }
  if (limits.engage_window_n().empty()) {
    for (const double force : limits.force_n()) {
      limits.add_engage_window_n(kEngageWindowPerForce * force);
    }
  }
  settings.slew_limit = read_list(limits.slew_n_per_s(), n_a, path + ".limits.slew_n_per_s", per,
                                  0.0, false, problems);
  settings.engage_window = read_list(limits.engage_window_n(), n_a,
                                     path + ".limits.engage_window_n", per, 0.0, false, problems);
  for (int i = 0; i < std::min<int>(limits.force_n_size(), static_cast<int>(max_effort.size()));
       ++i) {
    if (limits.force_n(i) > max_effort[i]) {
      problems.add(index(path + ".limits.force_n", i), limits.force_n(i),
                   "the device gives at most " + decimal(max_effort[i]));
    }
  }
}

void read_staleness(v1::DeviceScene& message, const std::string& path, DeviceScene& scene,
                    Problems& problems) {
  v1::StalenessScene& staleness = *message.mutable_staleness();
  core::StalenessLimits& limits = scene.settings.staleness;
  const bool has_fresh = staleness.has_fresh_end();
  limits.hold_end = read_duration(*staleness.mutable_hold_end(),
                                  staleness.hold_end().ByteSizeLong() > 0, limits.hold_end);
  limits.fade_end = read_duration(*staleness.mutable_fade_end(),
                                  staleness.fade_end().ByteSizeLong() > 0, limits.fade_end);
  if (has_fresh) {
    scene.fresh_end = read_duration(*staleness.mutable_fresh_end(), true, {});
    limits.fresh_end = *scene.fresh_end;
  } else {
    limits.fresh_end = std::min<core::Duration>(std::chrono::milliseconds(80), limits.hold_end);
  }
  if (const char* wrong = core::check(limits)) {
    const auto ms = [](core::Duration d) { return decimal(core::seconds(d) * 1e3) + " ms"; };
    problems.add(path + ".staleness",
                 ms(limits.fresh_end) + ", " + ms(limits.hold_end) + ", " + ms(limits.fade_end),
                 wrong);
  }
}

}  // namespace

core::Duration read_duration(google::protobuf::Duration& field, bool present,
                             core::Duration fallback) {
  if (!present) {
    field.set_seconds(fallback.count() / 1'000'000'000);
    field.set_nanos(static_cast<int>(fallback.count() % 1'000'000'000));
  }
  constexpr std::int64_t kLongest = 1'000'000;  // s; keeps the sum of ns far from overflow
  return std::chrono::seconds(std::clamp(field.seconds(), -kLongest, kLongest)) +
         core::Duration(field.nanos());
}

core::VecX read_list(const RepeatedField<double>& field, int wanted, const std::string& path,
                     const std::string& per, double lowest, bool lowest_allowed,
                     Problems& problems) {
  if (field.size() != wanted) {
    problems.add(path, std::to_string(field.size()) + " values",
                 "must be one per " + per + ", " + std::to_string(wanted));
    return {};
  }
  core::VecX values(wanted);
  for (int i = 0; i < wanted; ++i) {
    const double v = field.Get(i);
    const bool good = std::isfinite(v) && (lowest_allowed ? v >= lowest : v > lowest);
    if (!good) {
      problems.add(index(path, i), v,
                   lowest == kAny ? "must be finite"
                                  : std::string("must be ") + (lowest_allowed ? ">= " : "> ") +
                                        decimal(lowest));
    }
    values[i] = v;
  }
  return values;
}

DeviceScene read_device(v1::DeviceScene& message, const std::string& path,
                        const std::filesystem::path& folder, Problems& problems) {
  DeviceScene scene;
  check_name(message, path, problems);
  scene.name = message.name();
  scene.settings.renderer = read_renderer(message);
  scene.settings.direction_guard = message.has_direction_guard();
  scene.kinematics = read_kinematics(message, path, problems);
  if (!scene.kinematics) return scene;
  const core::VecA max_effort =
      read_source(message, path, folder, *scene.kinematics, scene.source, problems);
  read_limits(message, path, scene.kinematics->layout().n_a(), max_effort, scene.settings,
              problems);
  read_staleness(message, path, scene, problems);
  return scene;
}

}  // namespace haptic::server
