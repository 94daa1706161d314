// Where a device's motion comes from: hardware, simulations, recordings.
#include <fstream>
#include <sstream>

#include "haptic/v1/calibration.pb.h"
#include "hw/board/board_device.hpp"
#include "hw/replay/replay.hpp"
#include "hw/simulated/finger.hpp"
#include "hw/simulated/linear.hpp"
#include "server/scene/parts.hpp"
#include "server/scene/reader.hpp"
#include "server/scene/text.hpp"

namespace haptic::server {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCsvFile = "a CSV file";

/// The sizes a source must have; -1: not known.
struct Sizes {
  explicit Sizes(const core::DofLayout* layout)
      : n_q(layout == nullptr ? -1 : layout->n_q()), n_a(layout == nullptr ? -1 : layout->n_a()) {}
  int n_q;
  int n_a;
};

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
    c.motion_file = reader.file("motion_file", folder, kCsvFile);
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
  if (message.file().empty()) reader.missing("file", kCsvFile);
  c.file = reader.file("file", folder, kCsvFile);
  c.repeat = message.repeat();
  c.max_effort =
      to_vector(reader.list({"max_effort", Allowed::kPositive, sizes.n_a, "actuated DoF"}));
  return c;
}

/// "2026-11-21": a form, not a calendar.
bool is_date(const std::string& text) {
  if (text.size() != 10) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool dash = i == 4 || i == 7;
    if (dash ? text[i] != '-' : (text[i] < '0' || text[i] > '9')) return false;
  }
  return true;
}

/// Fills in DoF number `i` of the kinematics; why it cannot, or nothing.
std::string take_dof(const v1::Calibration& message, const core::DofSpec& dof, Eigen::Index i,
                     hw::board::Calibration& calibration) {
  const v1::Calibration::Dof* found = nullptr;
  for (const v1::Calibration::Dof& entry : message.dof()) {
    if (entry.name() != dof.name) continue;
    if (found != nullptr) return "has DoF '" + dof.name + "' twice";
    found = &entry;
  }
  if (found == nullptr) return "lacks DoF '" + dof.name + "'";
  calibration.scale[i] = found->scale();
  calibration.offset[i] = found->offset();
  calibration.lower[i] = found->lower();
  calibration.upper[i] = found->upper();
  return {};
}

/// Reads `file`; what is wrong is reported at `path`, the field that names it. The DoFs are put in
/// the order of `kinematics`, which may be null: then nothing comes back. The board's serial number
/// is compared when the board answers.
std::optional<hw::board::Calibration> read_calibration(const std::filesystem::path& file,
                                                       const std::string& path,
                                                       const core::Kinematics* kinematics,
                                                       Problems& problems) {
  const std::size_t before = problems.count();
  const auto wrong = [&](const std::string& why) {
    problems.wrong(path, quoted(file.string()), why);
  };
  std::ifstream stream(file);
  std::ostringstream text;
  if (stream) text << stream.rdbuf();
  v1::Calibration message;
  if (!stream) {
    wrong("must be a file of hapticctl calibrate; it cannot be read");
  } else if (const std::string found = parse_fragment(text.str(), message); !found.empty()) {
    wrong("must be a file of hapticctl calibrate: " + found);
  }
  if (problems.count() > before || kinematics == nullptr) return std::nullopt;

  hw::board::Calibration calibration;
  calibration.source = file.string();
  calibration.serial = message.device_serial();
  calibration.date = message.date();
  if (calibration.serial.empty()) wrong("device_serial: is required");
  if (!is_date(calibration.date))
    wrong("date = " + server::quoted(calibration.date) + ": must be YYYY-MM-DD");
  const auto& dofs = kinematics->dofs();
  const auto n_q = static_cast<Eigen::Index>(dofs.size());
  for (core::VecQ* list :
       {&calibration.scale, &calibration.offset, &calibration.lower, &calibration.upper}) {
    list->setZero(n_q);
  }
  if (message.dof_size() > n_q) {
    wrong("has " + std::to_string(message.dof_size()) + " DoFs; must have " + std::to_string(n_q));
  }
  for (Eigen::Index i = 0; i < n_q; ++i) {
    const std::string found = take_dof(message, dofs[static_cast<std::size_t>(i)], i, calibration);
    if (!found.empty()) wrong(found);
  }
  if (message.force_zero_size() > core::kMaxQ) {
    wrong("has " + std::to_string(message.force_zero_size()) + " zeros of force");
  } else {
    calibration.force_zero.resize(message.force_zero_size());
    for (int i = 0; i < message.force_zero_size(); ++i) {
      calibration.force_zero[i] = message.force_zero(i);
    }
  }
  if (problems.count() > before) return std::nullopt;
  return calibration;
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

std::shared_ptr<const hw::DeviceConfig> read_source(v1::DeviceScene& message,
                                                    const std::string& path, const fs::path& folder,
                                                    const core::Kinematics* kinematics,
                                                    Problems& problems) {
  check_fit(message, path, problems);
  const Sizes sizes(kinematics == nullptr ? nullptr : &kinematics->layout());
  const auto shared = [](auto config) {
    return std::make_shared<const decltype(config)>(std::move(config));
  };
  switch (message.source_case()) {
    case v1::DeviceScene::kSimulatedFinger:
      return shared(read_simulated_finger(*message.mutable_simulated_finger(),
                                          path + ".simulated_finger", folder, problems));
    case v1::DeviceScene::kSimulatedLinear:
      return shared(read_simulated_linear(*message.mutable_simulated_linear(),
                                          path + ".simulated_linear", sizes, problems));
    case v1::DeviceScene::kReplay:
      return shared(
          read_replay(*message.mutable_replay(), path + ".replay", folder, sizes, problems));
    case v1::DeviceScene::kBoard:
      return shared(read_board(*message.mutable_board(), path + ".board", folder, kinematics, sizes,
                               problems));
    case v1::DeviceScene::SOURCE_NOT_SET:
      break;
  }
  problems.missing(path + ".source", "one of simulated_finger, simulated_linear, replay, board");
  return nullptr;
}

}  // namespace haptic::server
