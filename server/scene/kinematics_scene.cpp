#include <cmath>

#include "haptic/core/error.hpp"
#include "haptic/core/model/linear.hpp"
#include "server/scene/device_scene.hpp"
#include "server/scene/finger_fields.hpp"
#include "server/scene/number_table.hpp"

namespace haptic::server {

namespace {

bool read_unit(const std::string& text, const std::string& path, Problems& problems,
               core::Unit& unit) {
  if (text == "m") {
    unit = core::Unit::kMetre;
  } else if (text == "rad") {
    unit = core::Unit::kRadian;
  } else {
    problems.add(path, "\"" + text + "\"", "must be \"m\" or \"rad\"");
    return false;
  }
  return true;
}

core::LinearMap read_linear(v1::LinearScene& scene, const std::string& path, Problems& problems) {
  core::LinearMap map;
  const int n_q = scene.dof_size(), n_x = scene.coordinate_size();
  if (n_q < 1 || n_q > core::kMaxQ) {
    problems.add(path + ".dof", std::to_string(n_q) + " entries",
                 "must be 1 to " + std::to_string(core::kMaxQ));
    return map;
  }
  if (n_x < 1 || n_x > core::kMaxX) {
    problems.add(path + ".coordinate", std::to_string(n_x) + " entries",
                 "must be 1 to " + std::to_string(core::kMaxX));
    return map;
  }
  bool any_actuated = false;
  for (int i = 0; i < n_q; ++i) {
    const v1::LinearScene::Dof& dof = scene.dof(i);
    const std::string at = path + ".dof[" + std::to_string(i) + "]";
    core::DofSpec spec{dof.name(), core::Unit::kMetre, dof.actuated(), dof.lower(), dof.upper()};
    if (dof.name().empty()) problems.missing(at + ".name", "must be given");
    read_unit(dof.unit(), at + ".unit", problems, spec.unit);
    if (!(std::isfinite(dof.lower()) && std::isfinite(dof.upper()) && dof.lower() < dof.upper())) {
      problems.add(at + ".upper", dof.upper(),
                   "must be finite and > lower, " + decimal(dof.lower()));
    }
    any_actuated = any_actuated || dof.actuated();
    map.dofs.push_back(spec);
  }
  if (!any_actuated) {
    problems.add(path + ".dof", "none actuated", "at least one must have actuated: true");
  }
  for (int i = 0; i < n_x; ++i) {
    const v1::LinearScene::Coordinate& c = scene.coordinate(i);
    const std::string at = path + ".coordinate[" + std::to_string(i) + "]";
    core::Coordinate spec{
        c.name(), core::Unit::kMetre,
        c.full_circle() ? core::CoordinateKind::kAngle : core::CoordinateKind::kLinear};
    if (c.name().empty()) problems.missing(at + ".name", "must be given");
    read_unit(c.unit(), at + ".unit", problems, spec.unit);
    if (c.full_circle() && c.unit() != "rad") {
      problems.add(at + ".unit", "\"" + c.unit() + "\"", "a full circle must be in \"rad\"");
    }
    if (c.unit() != scene.coordinate(0).unit()) {
      problems.add(at + ".unit", "\"" + c.unit() + "\"",
                   "all coordinates must have one unit: distances in mixed units need a metric "
                   "W_x, which this version does not offer");
    }
    map.coordinates.push_back(spec);
  }
  if (scene.a_size() != n_q * n_x) {
    problems.add(path + ".A", std::to_string(scene.a_size()) + " values",
                 "must be coordinates x dofs, " + std::to_string(n_x) + " x " +
                     std::to_string(n_q) + ", row by row");
    return map;
  }
  map.A.resize(n_x, n_q);
  for (int i = 0; i < n_x * n_q; ++i) {
    if (!std::isfinite(scene.a(i))) {
      problems.add(path + ".A[" + std::to_string(i) + "]", scene.a(i), "must be finite");
    }
    map.A(i / n_q, i % n_q) = scene.a(i);
  }
  if (scene.x_0_size() == 0) {
    for (int i = 0; i < n_x; ++i) scene.add_x_0(0.0);
  }
  map.x_0 = read_list(scene.x_0(), n_x, path + ".x_0", "coordinate", kAny, true, problems);
  return map;
}

}  // namespace

std::shared_ptr<const core::Kinematics> read_kinematics(v1::DeviceScene& message,
                                                        const std::string& path,
                                                        Problems& problems) {
  try {
    switch (message.kinematics_case()) {
      case v1::DeviceScene::kFingerExoskeleton: {
        core::FingerDimensions dimensions;
        const std::string at = path + ".finger_exoskeleton";
        if (!read_numbers(*message.mutable_finger_exoskeleton(), at, kFingerFields, dimensions,
                          problems)) {
          return nullptr;
        }
        return core::make_finger_exoskeleton(dimensions);
      }
      case v1::DeviceScene::kLinear: {
        const core::LinearMap map =
            read_linear(*message.mutable_linear(), path + ".linear", problems);
        return problems.any() ? nullptr : core::make_linear(map);
      }
      case v1::DeviceScene::KINEMATICS_NOT_SET:
        problems.missing(path + ".kinematics", "must be one of finger_exoskeleton, linear");
    }
  } catch (const core::SceneError& error) {
    problems.add(path, "kinematics", error.what());
  }
  return nullptr;
}

}  // namespace haptic::server
