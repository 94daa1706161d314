#include <algorithm>
#include <cmath>
#include <set>

#include "haptic/core/model/linear.hpp"
#include "server/owner/scene/parts.hpp"

namespace haptic::server {
namespace {

constexpr std::size_t kLongestEntryName = 32;

core::Unit read_unit(const Fields& part) {
  return part.word("unit", {"m", "rad"}) == 1 ? core::Unit::kRadian : core::Unit::kMetre;
}

/// Reports unless the list has 1 to `most` entries.
void check_count(const Fields& part, const char* list, int count, int most) {
  const std::string rule = "1 to " + std::to_string(most);
  if (count == 0) part.missing(list, rule);
  if (count > most) part.wrong(list, "[" + std::to_string(count) + " entries]", "must be " + rule);
}

core::DofSpec read_dof(const Part<v1::LinearScene::Dof>& part, std::set<std::string>& names) {
  part.entry_name(kLongestEntryName, names);
  const double lower = part->lower(), upper = part->upper();
  if (!std::isfinite(lower)) part.wrong("lower", decimal(lower), "must be finite");
  if (!std::isfinite(upper) || upper <= lower) {
    part.wrong("upper", decimal(upper), "must be finite and above lower, " + decimal(lower));
  }
  return {part->name(), read_unit(part), part->actuated(), lower, upper};
}

core::Coordinate read_coordinate(const Part<v1::LinearScene::Coordinate>& part,
                                 std::set<std::string>& names) {
  part.entry_name(kLongestEntryName, names);
  const core::Unit unit = read_unit(part);
  if (part->full_circle() && unit != core::Unit::kRadian) {
    part.wrong("full_circle", "true", R"(must be a coordinate in "rad")");
  }
  return {part->name(), unit,
          part->full_circle() ? core::CoordinateKind::kAngle : core::CoordinateKind::kLinear};
}

SharedKinematics read_linear(const Part<v1::LinearScene>& part) {
  const int n_q = part->dof_size(), n_x = part->coordinate_size();
  check_count(part, "dof", n_q, core::kMaxQ);
  check_count(part, "coordinate", n_x, core::kMaxX);
  if (!part.good()) return nullptr;

  core::LinearMap map;
  std::set<std::string> dofs, coordinates;
  for (const auto& dof : part.parts<v1::LinearScene::Dof>("dof")) {
    map.dofs.push_back(read_dof(dof, dofs));
  }
  if (std::none_of(map.dofs.begin(), map.dofs.end(),
                   [](const auto& dof) { return dof.actuated; })) {
    part.wrong("dof", "[none actuated]", "must have at least one with actuated: true");
  }
  for (const auto& coordinate : part.parts<v1::LinearScene::Coordinate>("coordinate")) {
    map.coordinates.push_back(read_coordinate(coordinate, coordinates));
  }
  const auto A = part.list({"A", Allowed::kFinite, n_x * n_q, "DoF and coordinate"});
  map.x_0 = part.list({"x_0", Allowed::kFinite, n_x, "coordinate"}, filled(n_x, 0.0));
  if (!part.good()) return nullptr;
  map.A = Eigen::Map<const Eigen::MatrixXd>(A.data(), n_q, n_x).transpose();  // given row by row
  return made(part, [&] { return core::make_linear(map); });
}

SharedKinematics read_finger_exoskeleton(const Part<v1::FingerExoskeletonScene>& part) {
  const core::FingerDimensions dimensions = read_dimensions(part);
  return made(part, [&] { return core::make_finger_exoskeleton(dimensions); });
}

}  // namespace

core::FingerDimensions read_dimensions(const Part<v1::FingerExoskeletonScene>& part) {
  const std::vector<std::string> names(core::kFingerLinkages.begin(), core::kFingerLinkages.end());
  const bool sign_change = part.word("linkage", names, names[0]) == 1;
  core::FingerDimensions d = sign_change ? core::finger_sign_change() : core::FingerDimensions{};
  part.numbers({
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
  part.above("slider1_upper_m", d.slider1_upper, d.slider1_lower);
  part.above("slider2_upper_m", d.slider2_upper, d.slider2_lower);
  part.above("l_x_upper_m", d.l_x_upper, d.l_x_lower);
  part.above("q_B_upper_rad", d.q_B_upper, d.q_B_lower);
  return d;
}

SharedKinematics read_kinematics(const Part<v1::DeviceScene>& part) {
  const std::string map = part.choice("kinematics");
  if (map == "finger_exoskeleton") {
    return read_finger_exoskeleton(part.part<v1::FingerExoskeletonScene>(map));
  }
  if (map == "linear") return read_linear(part.part<v1::LinearScene>(map));
  if (map == "hand_exoskeleton") {
    return read_hand_exoskeleton(part.part<v1::HandExoskeletonScene>(map));
  }
  if (map == "tracked_hand") return read_tracked_hand(part.part<v1::TrackedHandScene>(map));
  if (map == "stylus") return read_stylus(part.part<v1::StylusScene>(map));
  if (map == "serial_chain") return read_serial_chain(part.part<v1::SerialChainScene>(map));
  return nullptr;
}

}  // namespace haptic::server
