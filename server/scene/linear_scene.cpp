#include <cmath>
#include <set>

#include "haptic/core/model/linear.hpp"
#include "server/scene/entry_name.hpp"
#include "server/scene/field_reader.hpp"
#include "server/scene/kinematics_scene.hpp"

namespace haptic::server {
namespace {

constexpr std::size_t kLongestEntryName = 32;

core::Unit read_unit(const FieldReader& reader, const std::string& text) {
  if (text != "m" && text != "rad") {
    reader.wrong("unit", quoted(text), R"(must be "m" or "rad")");
  }
  return text == "rad" ? core::Unit::kRadian : core::Unit::kMetre;
}

/// Between 1 and `most`; what is above is reported and not read.
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
  check_entry_name(reader, dof.name(), kLongestEntryName, names);
  if (!std::isfinite(dof.lower())) reader.wrong("lower", decimal(dof.lower()), "must be finite");
  if (!std::isfinite(dof.upper()) || dof.upper() <= dof.lower()) {
    reader.wrong("upper", decimal(dof.upper()),
                 "must be finite and above lower, " + decimal(dof.lower()));
  }
  return {dof.name(), read_unit(reader, dof.unit()), dof.actuated(), dof.lower(), dof.upper()};
}

core::Coordinate read_coordinate(v1::LinearScene::Coordinate& coordinate, const FieldReader& reader,
                                 std::set<std::string>& names) {
  check_entry_name(reader, coordinate.name(), kLongestEntryName, names);
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

}  // namespace

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

}  // namespace haptic::server
