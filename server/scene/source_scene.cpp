#include "server/scene/source_scene.hpp"

#include "server/scene/calibration_scene.hpp"
#include "server/scene/field_reader.hpp"

namespace haptic::server {
namespace {

namespace fs = std::filesystem;

/// The sizes a source must have; -1: not known.
struct Sizes {
  explicit Sizes(const core::DofLayout* layout)
      : n_q(layout == nullptr ? -1 : layout->n_q()), n_a(layout == nullptr ? -1 : layout->n_a()) {}
  int n_q;
  int n_a;
};

/// A recording's full path, so that the resolved scene can be read from any
/// folder.
fs::path find_recording(const std::string& file, const fs::path& folder, const char* field,
                        const FieldReader& reader) {
  fs::path full = fs::absolute(folder / file).lexically_normal();
  std::error_code unreadable;
  if (!fs::is_regular_file(full, unreadable)) {
    reader.wrong(field, quoted(file), "must be a CSV file; there is none at " + full.string());
  }
  return full;
}

void refuse_both(const FieldReader& reader, bool has_target) {
  if (!has_target) return;
  reader.wrong("motion_file", "given with target_mcp_rad or target_pip_rad",
               "must be one or the other: the finger goes where the file says, "
               "or to the target");
}

hw::SimulatedFingerConfig read_simulated_finger(v1::SimulatedFinger& message,
                                                const std::string& path, const fs::path& folder,
                                                Problems& problems) {
  const FieldReader reader(message, path, problems);
  hw::SimulatedFingerConfig c;
  if (!message.has_seed()) message.set_seed(c.seed);
  c.seed = message.seed();
  if (message.motion_file().empty()) {
    reader.numbers({{"target_mcp_rad", &c.target_mcp, Allowed::kFinite},
                    {"target_pip_rad", &c.target_pip, Allowed::kFinite}});
  } else {
    refuse_both(reader, message.has_target_mcp_rad() || message.has_target_pip_rad());
    c.motion_file = find_recording(message.motion_file(), folder, "motion_file", reader);
    message.set_motion_file(c.motion_file.string());
  }
  reader.numbers({
      {"hand_stiffness", &c.hand_stiffness, Allowed::kPositive},
      {"hand_damping", &c.hand_damping, Allowed::kNotNegative},
      {"actuator_mass_kg", &c.actuator_mass, Allowed::kPositive},
      {"actuator_damping", &c.actuator_damping, Allowed::kNotNegative},
      {"actuator_friction_n", &c.actuator_friction, Allowed::kNotNegative},
      {"actuator_force_limit_n", &c.actuator_force_limit, Allowed::kPositive},
      {"noise_l_x_m", &c.noise_l_x, Allowed::kNotNegative},
      {"noise_q_B_rad", &c.noise_q_B, Allowed::kNotNegative},
      {"resolution_l_x_m", &c.resolution_l_x, Allowed::kNotNegative},
      {"resolution_q_B_rad", &c.resolution_q_B, Allowed::kNotNegative},
  });
  return c;
}

hw::SimulatedLinearConfig read_simulated_linear(v1::SimulatedLinear& message,
                                                const std::string& path, Sizes sizes,
                                                Problems& problems) {
  const FieldReader reader(message, path, problems);
  const std::vector<double> zeros(static_cast<std::size_t>(std::max(sizes.n_q, 0)));
  const auto per_dof = [&](const char* name, Allowed allowed) {
    return to_vector(reader.list({name, allowed, sizes.n_q, "DoF"}, zeros));
  };
  hw::SimulatedLinearConfig c;
  c.mass = to_vector(reader.list({"mass", Allowed::kPositive, sizes.n_q, "DoF"}));
  c.damping = per_dof("damping", Allowed::kNotNegative);
  c.hand_stiffness = per_dof("hand_stiffness", Allowed::kNotNegative);
  c.hand_damping = per_dof("hand_damping", Allowed::kNotNegative);
  c.target = per_dof("target", Allowed::kFinite);
  c.max_effort =
      to_vector(reader.list({"max_effort", Allowed::kPositive, sizes.n_a, "actuated DoF"}));
  return c;
}

hw::ReplayConfig read_replay(v1::Replay& message, const std::string& path, const fs::path& folder,
                             Sizes sizes, Problems& problems) {
  const FieldReader reader(message, path, problems);
  hw::ReplayConfig c;
  if (message.file().empty()) {
    reader.missing("file", "a CSV file");
  } else {
    c.file = find_recording(message.file(), folder, "file", reader);
    message.set_file(c.file.string());
  }
  c.repeat = message.repeat();
  c.max_effort =
      to_vector(reader.list({"max_effort", Allowed::kPositive, sizes.n_a, "actuated DoF"}));
  return c;
}

hw::BoardConfig read_board(v1::Board& message, const std::string& path, const fs::path& folder,
                           const core::Kinematics* kinematics, Sizes sizes, Problems& problems) {
  const FieldReader reader(message, path, problems);
  hw::BoardConfig c;
  if (message.port().empty()) reader.missing("port", "a serial port, as in \"/dev/ttyACM0\"");
  c.port = message.port();
  if (!message.has_baud()) message.set_baud(static_cast<std::uint32_t>(c.baud));
  reader.whole_number("baud", message.baud(), 9600, 12'000'000);
  c.baud = static_cast<int>(message.baud());
  c.serial = message.serial();
  c.max_effort =
      to_vector(reader.list({"max_effort", Allowed::kPositive, sizes.n_a, "actuated DoF"}));
  c.max_silence = reader.duration("max_silence", c.max_silence,
                                  {std::chrono::milliseconds(2), std::chrono::milliseconds(100)});
  if (!message.calibration_file().empty()) {
    const fs::path file = fs::absolute(folder / message.calibration_file()).lexically_normal();
    c.calibration = read_calibration(file, path + ".calibration_file", kinematics, problems);
    message.set_calibration_file(file.string());
  }
  return c;
}

/// Reports a simulation that goes with another map.
void check_fit(const v1::DeviceScene& message, const std::string& path, Problems& problems) {
  const auto* oneof = v1::DeviceScene::descriptor()->FindOneofByName("kinematics");
  const auto* map = v1::DeviceScene::GetReflection()->GetOneofFieldDescriptor(message, oneof);
  if (map == nullptr) return;  // reported elsewhere
  if (message.has_simulated_finger() && !message.has_finger_exoskeleton()) {
    problems.wrong(path + ".simulated_finger", "{ ... } with " + map->name(),
                   "must go with finger_exoskeleton");
  }
  if (message.has_simulated_linear() && message.has_finger_exoskeleton()) {
    problems.wrong(path + ".simulated_linear", "{ ... } with " + map->name(),
                   "must go with another kinematics: a finger has simulated_finger");
  }
}

}  // namespace

Source read_source(v1::DeviceScene& message, const std::string& path, const fs::path& folder,
                   const core::Kinematics* kinematics, Problems& problems) {
  check_fit(message, path, problems);
  const Sizes sizes(kinematics == nullptr ? nullptr : &kinematics->layout());
  switch (message.source_case()) {
    case v1::DeviceScene::kSimulatedFinger: {
      const auto config = read_simulated_finger(*message.mutable_simulated_finger(),
                                                path + ".simulated_finger", folder, problems);
      return {config, core::VecA::Constant(1, config.actuator_force_limit)};
    }
    case v1::DeviceScene::kSimulatedLinear: {
      const auto config = read_simulated_linear(*message.mutable_simulated_linear(),
                                                path + ".simulated_linear", sizes, problems);
      return {config, config.max_effort};
    }
    case v1::DeviceScene::kReplay: {
      const auto config =
          read_replay(*message.mutable_replay(), path + ".replay", folder, sizes, problems);
      return {config, config.max_effort};
    }
    case v1::DeviceScene::kBoard: {
      const auto config = read_board(*message.mutable_board(), path + ".board", folder, kinematics,
                                     sizes, problems);
      return {config, config.max_effort};
    }
    case v1::DeviceScene::SOURCE_NOT_SET:
      break;
  }
  problems.missing(path + ".source", "one of simulated_finger, simulated_linear, replay, board");
  return {};
}

}  // namespace haptic::server
