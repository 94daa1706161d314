// Where a device's motion comes from: hardware, simulations, recordings.
#include <map>

#include "haptic/v1/calibration.pb.h"
#include "hw/board/board_device.hpp"
#include "hw/plain_file.hpp"
#include "hw/replay/replay.hpp"
#include "hw/replay/tracked_orientation.hpp"
#include "hw/simulated/hand.hpp"
#include "hw/simulated/linear.hpp"
#include "server/owner/scene/parts.hpp"
#include "server/owner/scene/text.hpp"

namespace haptic::server {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCsvFile = "a CSV file";

using Device = Part<v1::DeviceScene>;

/// Largest effort of any source but a simulation, which has its own.
core::VecA read_effort(const Fields& part, int n_a) {
  return part.per_actuated("max_effort", Allowed::kPositive, n_a);
}

/// Common part of a finger and a hand.
template <typename Message>
void read_worn_finger(const Part<Message>& part, hw::WornFinger& worn) {
  part.numbers({
      {"hand_stiffness", &worn.finger.hand_stiffness, Allowed::kPositive},
      {"hand_damping", &worn.finger.hand_damping, Allowed::kNotNegative},
      {"actuator_mass_kg", &worn.finger.actuator_mass, Allowed::kPositive},
      {"actuator_damping", &worn.finger.actuator_damping, Allowed::kNotNegative},
      {"actuator_friction_n", &worn.finger.actuator_friction, Allowed::kNotNegative},
      {"actuator_force_limit_n", &worn.actuator_force_limit, Allowed::kPositive},
      {"noise_l_x_m", &worn.noise_l_x, Allowed::kNotNegative},
      {"noise_q_B_rad", &worn.noise_q_B, Allowed::kNotNegative},
      {"resolution_l_x_m", &worn.resolution_l_x, Allowed::kNotNegative},
      {"resolution_q_B_rad", &worn.resolution_q_B, Allowed::kNotNegative},
  });
}

hw::SimulatedHandConfig read_simulated_finger(const Part<v1::SimulatedFinger>& part) {
  hw::SimulatedHandConfig c;
  c.target.setZero(2);
  if (!part->has_seed()) part->set_seed(c.seed);
  c.seed = part->seed();
  if (part->motion_file().empty()) {
    part.numbers({{"target_mcp_rad", &c.target[0], Allowed::kFinite},
                  {"target_pip_rad", &c.target[1], Allowed::kFinite}});
  } else if (part->has_target_mcp_rad() || part->has_target_pip_rad()) {
    part.wrong("motion_file", "given with target_mcp_rad or target_pip_rad",
               "must be one or the other: the finger goes where the file says, or to the target");
  }
  c.motion_file = part.file("motion_file", kCsvFile);
  read_worn_finger(part, c);
  return c;
}

hw::ArmParameters read_arm(const Fields& part) {
  hw::ArmParameters arm;
  part.numbers({{"mass_kg", &arm.mass, Allowed::kPositive},
                {"inertia_kg_m2", &arm.inertia, Allowed::kPositive},
                {"stiffness", &arm.stiffness, Allowed::kPositive},
                {"damping", &arm.damping, Allowed::kNotNegative},
                {"rotation_stiffness", &arm.rotation_stiffness, Allowed::kPositive},
                {"rotation_damping", &arm.rotation_damping, Allowed::kNotNegative}});
  return arm;
}

hw::SimulatedHandConfig read_simulated_hand(const Part<v1::SimulatedHand>& part,
                                            const core::Kinematics* kinematics) {
  const int n_q = kinematics == nullptr ? -1 : kinematics->layout().n_q();
  hw::SimulatedHandConfig c;
  c.fingers = kinematics == nullptr ? 0 : kinematics->layout().n_a();
  if (!part->has_seed()) part->set_seed(c.seed);
  c.seed = part->seed();
  c.motion_file = part.file("motion_file", kCsvFile);
  c.target = part.list({"target", Allowed::kFinite, n_q, "DoF"}, filled(n_q, 0.0));
  read_worn_finger(part, c);
  if (kinematics == nullptr) return c;
  // In q a palm is x, y, z and then its rotation vector.
  const auto rotation = hw::rotation_vector_in(kinematics->dofs());
  if (!rotation) {
    if (part->has_arm()) {
      part.wrong("arm", "{ ... } with a palm that stands still", "must go with tracked_hand");
    }
    return c;
  }
  c.arm = read_arm(part.part<v1::ArmScene>("arm"));
  for (std::size_t i = *rotation - 3; i < *rotation && c.target.size() == n_q; ++i) {
    const core::DofSpec& dof = kinematics->dofs()[i];
    const double aim = c.target[static_cast<Eigen::Index>(i)];
    if (aim >= dof.lower && aim <= dof.upper) continue;
    part.wrong(
        {"target", i}, decimal(aim),
        "must be within the palm's box, " + decimal(dof.lower) + " to " + decimal(dof.upper));
  }
  return c;
}

hw::SimulatedLinearConfig read_simulated_linear(const Part<v1::SimulatedLinear>& part, int n_q,
                                                int n_a) {
  const auto per_dof = [&](const char* name, Allowed allowed) {
    return part.list({name, allowed, n_q, "DoF"}, filled(n_q, 0.0));
  };
  hw::SimulatedLinearConfig c;
  c.mass = part.list({"mass", Allowed::kPositive, n_q, "DoF"});
  c.damping = per_dof("damping", Allowed::kNotNegative);
  c.hand_stiffness = per_dof("hand_stiffness", Allowed::kNotNegative);
  c.hand_damping = per_dof("hand_damping", Allowed::kNotNegative);
  c.target = per_dof("target", Allowed::kFinite);
  c.max_effort = read_effort(part, n_a);
  return c;
}

hw::ReplayConfig read_replay(const Part<v1::Replay>& part, int n_a) {
  hw::ReplayConfig c;
  if (part->file().empty()) part.missing("file", kCsvFile);
  c.file = part.file("file", kCsvFile);
  c.repeat = part->repeat();
  c.max_effort = read_effort(part, n_a);
  return c;
}

/// Reads a file of hapticctl calibrate, which is there; what is wrong is reported at
/// calibration_file. The DoFs are put in the order of `kinematics`; if that is null, nothing comes
/// back. The board's serial number is compared when the board answers.
std::optional<hw::board::Calibration> read_calibration(const Part<v1::Board>& part,
                                                       const core::Kinematics* kinematics) {
  const std::size_t before = part.problems().count();
  const std::string& file = part->calibration_file();
  const auto wrong = [&](const std::string& why) {
    part.wrong("calibration_file", quoted(file), why);
  };
  std::string unlike;
  const std::string text = hw::read_plain_file(file, kLargestScene, unlike);
  v1::Calibration message;
  if (unlike.empty()) unlike = parse_fragment(text, message);
  if (!unlike.empty()) wrong("must be a file of hapticctl calibrate: " + unlike);
  if (part.problems().count() > before || kinematics == nullptr) return std::nullopt;

  hw::board::Calibration calibration;
  calibration.source = file;
  calibration.serial = message.device_serial();
  calibration.date = message.date();
  if (calibration.serial.empty()) wrong("device_serial: is required");
  if (!matches(calibration.date, "[0-9]{4}-[0-9]{2}-[0-9]{2}")) {
    wrong("date = " + server::quoted(calibration.date) + ": must be YYYY-MM-DD");
  }
  std::map<std::string, v1::Calibration::Dof> found;
  for (const v1::Calibration::Dof& dof : message.dof()) {
    if (!found.emplace(dof.name(), dof).second) wrong("has DoF '" + dof.name() + "' twice");
  }
  const auto n_q = static_cast<Eigen::Index>(kinematics->dofs().size());
  if (message.dof_size() > n_q) {
    wrong("has " + std::to_string(message.dof_size()) + " DoFs; must have " + std::to_string(n_q));
  }
  for (core::VecQ* list :
       {&calibration.scale, &calibration.offset, &calibration.lower, &calibration.upper}) {
    list->setZero(n_q);
  }
  for (Eigen::Index i = 0; i < n_q; ++i) {
    const std::string& name = kinematics->dofs()[static_cast<std::size_t>(i)].name;
    if (found.count(name) == 0) wrong("lacks DoF '" + name + "'");
    const v1::Calibration::Dof& dof = found[name];
    calibration.scale[i] = dof.scale();
    calibration.offset[i] = dof.offset();
    calibration.lower[i] = dof.lower();
    calibration.upper[i] = dof.upper();
  }
  const auto& zeros = message.force_zero();
  if (zeros.size() > core::kMaxQ) {
    wrong("has " + std::to_string(zeros.size()) + " zeros of force");
  } else {
    calibration.force_zero = Eigen::Map<const Eigen::VectorXd>(zeros.data(), zeros.size());
  }
  if (part.problems().count() > before) return std::nullopt;
  return calibration;
}

/// One of core::kFingerLinkages, if every dimension of the scene is that linkage's.
std::string linkage_of(const Device& device) {
  if (!device->has_finger_exoskeleton()) return {};
  const auto part = device.part<v1::FingerExoskeletonScene>("finger_exoskeleton");
  const core::FingerDimensions dimensions = read_dimensions(part);
  if (dimensions == core::FingerDimensions{}) return std::string(core::kFingerLinkages[0]);
  if (dimensions == core::finger_sign_change()) return std::string(core::kFingerLinkages[1]);
  return {};
}

hw::BoardConfig read_board(const Part<v1::Board>& part, const core::Kinematics* kinematics,
                           int n_a) {
  hw::BoardConfig c;
  if (part->port().empty()) part.missing("port", "a serial port, as in \"/dev/ttyACM0\"");
  c.port = part->port();
  c.baud = part.whole_number("baud", c.baud, 9600, 12'000'000);
  c.serial = part->serial();
  c.max_effort = read_effort(part, n_a);
  c.max_silence = part.duration("max_silence", c.max_silence,
                                {std::chrono::milliseconds(2), std::chrono::milliseconds(100)});
  const std::size_t before = part.problems().count();
  const fs::path file = part.file("calibration_file", "a file of hapticctl calibrate");
  if (!file.empty() && part.problems().count() == before) {
    c.calibration = read_calibration(part, kinematics);
  }
  return c;
}

/// Reports a simulation that goes with another map.
void check_fit(const Device& device, const std::string& source) {
  if (device->kinematics_case() == v1::DeviceScene::KINEMATICS_NOT_SET) return;  // reported
  const std::string map = device.choice("kinematics");
  const bool finger = device->has_finger_exoskeleton();
  const bool hand = device->has_hand_exoskeleton() || device->has_tracked_hand();
  if (source == "simulated_finger" && !finger) {
    device.wrong(source, "{ ... } with " + map, "must go with finger_exoskeleton");
  }
  if (source == "simulated_hand" && !hand) {
    device.wrong(source, "{ ... } with " + map, "must go with hand_exoskeleton or tracked_hand");
  }
  if (source == "simulated_linear" && finger) {
    device.wrong(source, "{ ... } with " + map,
                 "must go with another kinematics: a finger has simulated_finger");
  }
}

template <typename Config>
std::shared_ptr<const hw::DeviceConfig> shared(Config config) {
  return std::make_shared<const Config>(std::move(config));
}

}  // namespace

std::shared_ptr<const hw::DeviceConfig> read_source(const Device& device,
                                                    const core::Kinematics* kinematics) {
  const int n_q = kinematics == nullptr ? -1 : kinematics->layout().n_q();
  const int n_a = kinematics == nullptr ? -1 : kinematics->layout().n_a();
  const std::string source = device.choice("source");
  check_fit(device, source);
  if (source == "simulated_finger") {
    return shared(read_simulated_finger(device.part<v1::SimulatedFinger>(source)));
  }
  if (source == "simulated_hand") {
    return shared(read_simulated_hand(device.part<v1::SimulatedHand>(source), kinematics));
  }
  if (source == "simulated_linear") {
    return shared(read_simulated_linear(device.part<v1::SimulatedLinear>(source), n_q, n_a));
  }
  if (source == "replay") return shared(read_replay(device.part<v1::Replay>(source), n_a));
  if (source == "board") {
    hw::BoardConfig config = read_board(device.part<v1::Board>(source), kinematics, n_a);
    if (kinematics != nullptr) config.linkage = linkage_of(device);  // else reported
    return shared(std::move(config));
  }
  return nullptr;
}

core::SensorFilter read_filter(const Device& device) {
  const auto part = device.part<v1::SensorFilterScene>("sensor_filter");
  const DurationRange range{core::Duration{0}, std::chrono::milliseconds(20)};
  core::SensorFilter filter = core::kDefaultFilter;
  // A recording is played as it is, unless the scene asks for a filter.
  if (device->has_replay()) filter.sensed_lag = filter.actuated_lag = core::Duration{0};
  filter.sensed_lag = part.duration("sensed_lag", filter.sensed_lag, range);
  filter.rate_lag = part.duration("rate_lag", filter.rate_lag, range);
  filter.actuated_lag = part.duration("actuated_lag", filter.actuated_lag, range);
  return filter;
}

}  // namespace haptic::server
