#include <cmath>
#include <set>

#include "haptic/core/error.hpp"
#include "haptic/core/model/linear.hpp"
#include "server/scene/parts.hpp"
#include "server/scene/reader.hpp"

namespace haptic::server {
namespace {

constexpr std::size_t kLongestEntryName = 32;

void check_order(const FieldReader& reader, const core::FingerDimensions& d) {
  struct Range {
    const char* upper_name;
    double lower, upper;
  };
  for (const Range& range : {Range{"slider1_upper_m", d.slider1_lower, d.slider1_upper},
                             Range{"slider2_upper_m", d.slider2_lower, d.slider2_upper},
                             Range{"l_x_upper_m", d.l_x_lower, d.l_x_upper},
                             Range{"q_B_upper_rad", d.q_B_lower, d.q_B_upper}}) {
    if (range.upper <= range.lower) {
      reader.wrong(range.upper_name, decimal(range.upper),
                   "must be above its lower limit, " + decimal(range.lower));
    }
  }
}

core::Unit read_unit(const FieldReader& reader, const std::string& text) {
  if (text != "m" && text != "rad") {
    reader.wrong("unit", quoted(text), R"(must be "m" or "rad")");
  }
  return text == "rad" ? core::Unit::kRadian : core::Unit::kMetre;
}

/// Reports unless `count` is 1 to `most`.
bool has_entries(const FieldReader& reader, const char* list, int count, int most) {
  if (count >= 1 && count <= most) return true;
  const std::string rule = "1 to " + std::to_string(most);
  if (count == 0) {
    reader.missing(list, rule);
  } else {
    reader.wrong(list, "[" + std::to_string(count) + " entries]", "must be " + rule);
  }
  return false;
}

core::DofSpec read_dof(v1::LinearScene::Dof& dof, const FieldReader& reader,
                       std::set<std::string>& names) {
  reader.entry_name(kLongestEntryName, names);
  if (!std::isfinite(dof.lower())) reader.wrong("lower", decimal(dof.lower()), "must be finite");
  if (!std::isfinite(dof.upper()) || dof.upper() <= dof.lower()) {
    reader.wrong("upper", decimal(dof.upper()),
                 "must be finite and above lower, " + decimal(dof.lower()));
  }
  return {dof.name(), read_unit(reader, dof.unit()), dof.actuated(), dof.lower(), dof.upper()};
}

core::Coordinate read_coordinate(v1::LinearScene::Coordinate& coordinate, const FieldReader& reader,
                                 std::set<std::string>& names) {
  reader.entry_name(kLongestEntryName, names);
  const core::Unit unit = read_unit(reader, coordinate.unit());
  if (coordinate.full_circle() && unit != core::Unit::kRadian) {
    reader.wrong("full_circle", "true", R"(must be a coordinate in "rad")");
  }
  return {coordinate.name(), unit,
          coordinate.full_circle() ? core::CoordinateKind::kAngle : core::CoordinateKind::kLinear};
}

void read_dofs(v1::LinearScene& message, const std::string& path, Problems& problems,
               core::LinearMap& map) {
  std::set<std::string> names;
  bool actuated = false;
  for (int i = 0; i < message.dof_size(); ++i) {
    const FieldReader reader(*message.mutable_dof(i), path + "." + entry("dof", i), problems);
    map.dofs.push_back(read_dof(*message.mutable_dof(i), reader, names));
    actuated = actuated || map.dofs.back().actuated;
  }
  if (!actuated) {
    problems.wrong(path + ".dof", "[none actuated]", "must have at least one with actuated: true");
  }
}

void read_coordinates(v1::LinearScene& message, const std::string& path, Problems& problems,
                      core::LinearMap& map) {
  std::set<std::string> names;
  for (int i = 0; i < message.coordinate_size(); ++i) {
    const FieldReader reader(*message.mutable_coordinate(i), path + "." + entry("coordinate", i),
                             problems);
    map.coordinates.push_back(read_coordinate(*message.mutable_coordinate(i), reader, names));
  }
}

SharedKinematics read_linear(v1::LinearScene& message, const std::string& path,
                             Problems& problems) {
  const std::size_t before = problems.count();
  const FieldReader reader(message, path, problems);
  const int n_q = message.dof_size(), n_x = message.coordinate_size();
  const bool dofs_fit = has_entries(reader, "dof", n_q, core::kMaxQ);
  const bool coordinates_fit = has_entries(reader, "coordinate", n_x, core::kMaxX);
  if (!dofs_fit || !coordinates_fit) return nullptr;

  core::LinearMap map;
  read_dofs(message, path, problems, map);
  read_coordinates(message, path, problems, map);
  const std::vector<double> A =
      reader.list({"A", Allowed::kFinite, n_x * n_q, "DoF and coordinate"});
  const std::vector<double> x_0 = reader.list({"x_0", Allowed::kFinite, n_x, "coordinate"},
                                              std::vector<double>(static_cast<std::size_t>(n_x)));
  if (problems.count() > before) return nullptr;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  map.A = Eigen::Map<const RowMajor>(A.data(), n_x, n_q);
  map.x_0 = Eigen::Map<const Eigen::VectorXd>(x_0.data(), n_x);
  return made([&] { return core::make_linear(map); }, path, problems);
}

SharedKinematics read_finger_exoskeleton(v1::FingerExoskeletonScene& message,
                                         const std::string& path, Problems& problems) {
  const std::size_t before = problems.count();
  const core::FingerDimensions dimensions = read_dimensions(message, path, problems);
  if (problems.count() > before) return nullptr;
  return made([&] { return core::make_finger_exoskeleton(dimensions); }, path, problems);
}

}  // namespace

core::FingerDimensions read_dimensions(v1::FingerExoskeletonScene& message, const std::string& path,
                                       Problems& problems) {
  const FieldReader reader(message, path, problems);
  core::FingerDimensions d;
  reader.numbers({
      {"proximal_phalanx_m", &d.proximal_phalanx, Allowed::kPositive},
      {"rail_origin_x_m", &d.rail_origin.x, Allowed::kFinite},
      {"rail_origin_y_m", &d.rail_origin.y, Allowed::kFinite},
      {"rail_angle_rad", &d.rail_angle, Allowed::kFinite},
      {"body_d_x_m", &d.body_d.x, Allowed::kFinite},
      {"body_d_y_m", &d.body_d.y, Allowed::kFinite},
      {"body_e_x_m", &d.body_e.x, Allowed::kFinite},
      {"body_e_y_m", &d.body_e.y, Allowed::kFinite},
      {"rod1_m", &d.rod1, Allowed::kPositive},
      {"rod2_m", &d.rod2, Allowed::kPositive},
      {"slider1_lower_m", &d.slider1_lower, Allowed::kPositive},
      {"slider1_upper_m", &d.slider1_upper, Allowed::kPositive},
      {"slider2_lower_m", &d.slider2_lower, Allowed::kPositive},
      {"slider2_upper_m", &d.slider2_upper, Allowed::kPositive},
      {"l_x_lower_m", &d.l_x_lower, Allowed::kFinite},
      {"l_x_upper_m", &d.l_x_upper, Allowed::kFinite},
      {"q_B_lower_rad", &d.q_B_lower, Allowed::kFinite},
      {"q_B_upper_rad", &d.q_B_upper, Allowed::kFinite},
  });
  check_order(reader, d);
  return d;
}

SharedKinematics made(const std::function<std::unique_ptr<core::Kinematics>()>& make,
                      const std::string& path, Problems& problems) {
  try {
    return make();
  } catch (const core::SceneError& error) {
    problems.wrong(path, "{ ... }", error.what());
    return nullptr;
  }
}

SharedKinematics read_kinematics(v1::DeviceScene& message, const std::string& path,
                                 Problems& problems) {
  switch (message.kinematics_case()) {
    case v1::DeviceScene::kFingerExoskeleton:
      return read_finger_exoskeleton(*message.mutable_finger_exoskeleton(),
                                     path + ".finger_exoskeleton", problems);
    case v1::DeviceScene::kLinear:
      return read_linear(*message.mutable_linear(), path + ".linear", problems);
    case v1::DeviceScene::kHandExoskeleton:
      return read_hand_exoskeleton(*message.mutable_hand_exoskeleton(), path + ".hand_exoskeleton",
                                   problems);
    case v1::DeviceScene::kTrackedHand:
      return read_tracked_hand(*message.mutable_tracked_hand(), path + ".tracked_hand", problems);
    case v1::DeviceScene::kStylus:
      return read_stylus(*message.mutable_stylus(), path + ".stylus", problems);
    case v1::DeviceScene::kSerialChain:
      return read_serial_chain(*message.mutable_serial_chain(), path + ".serial_chain", problems);
    case v1::DeviceScene::KINEMATICS_NOT_SET:
      break;
  }
  problems.missing(
      path + ".kinematics",
      "one of finger_exoskeleton, linear, hand_exoskeleton, tracked_hand, stylus, serial_chain");
  return nullptr;
}

}  // namespace haptic::server
