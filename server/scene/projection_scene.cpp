#include "server/scene/projection_scene.hpp"

#include <cmath>

#include "haptic/core/error.hpp"
#include "server/scene/field_reader.hpp"

namespace haptic::server {
namespace {

core::TaskMetric read_matrix(v1::MetricScene& message, const FieldReader& reader, int n_x) {
  if (message.has_scale_m() || message.has_scale_rad()) {
    reader.wrong("W", "{ beside scales }", "must be either W or scale_m and scale_rad");
    return {};
  }
  const std::vector<double> values =
      reader.list({"W", Allowed::kFinite, n_x * n_x, "pair of coordinates"});
  if (values.empty()) return {};
  try {
    return core::TaskMetric::from_matrix(
        Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
            values.data(), n_x, n_x));
  } catch (const core::SceneError& error) {
    reader.wrong("W", decimal(values), error.what());
    return {};
  }
}

core::TaskMetric read_metric(v1::MetricScene& message, const std::string& path,
                             const core::ConfigurationSpace& space, Problems& problems) {
  const std::size_t before = problems.count();
  const FieldReader reader(message, path, problems);
  if (message.w_size() > 0) return read_matrix(message, reader, space.n_x());
  double metres = 0.005, radians = 0.1;  // core/METHOD.md#metric-and-limits
  reader.numbers(
      {{"scale_m", &metres, Allowed::kPositive}, {"scale_rad", &radians, Allowed::kPositive}});
  if (problems.count() > before) return {};
  core::VecX scale(space.n_x());
  for (int i = 0; i < space.n_x(); ++i) {
    const core::Coordinate& coordinate = space.coordinates()[static_cast<std::size_t>(i)];
    // A chord of quaternions is half the angle between them.
    const bool half = coordinate.kind == core::CoordinateKind::kQuaternion;
    scale[i] = coordinate.unit == core::Unit::kMetre ? metres : half ? 0.5 * radians : radians;
  }
  return core::TaskMetric::from_scales(scale);
}

core::Prior read_prior(v1::PriorScene& message, const std::string& path, int n_n,
                       Problems& problems) {
  const FieldReader reader(message, path, problems);
  core::Prior prior;
  prior.weight = message.weight();
  if (!(std::isfinite(prior.weight) && prior.weight > 0.0)) {
    reader.wrong("weight", decimal(prior.weight), "must be finite and > 0");
  }
  prior.sensed_stiffness =
      to_vector(reader.list({"sensed_stiffness", Allowed::kPositive, n_n, "sensed DoF"}));
  return prior;
}

}  // namespace

core::ProjectionSettings read_projection(v1::DeviceScene& message, const std::string& path,
                                         const core::Kinematics* kinematics, Problems& problems) {
  core::ProjectionSettings settings;
  if (kinematics == nullptr) return settings;
  const std::size_t before = problems.count();
  if (message.has_metric()) {
    settings.metric =
        read_metric(*message.mutable_metric(), path + ".metric", kinematics->space(), problems);
  } else if (kinematics->space().mixes_units()) {
    problems.missing(path + ".metric", "x holds metres and radians, which have no common distance");
  }
  if (message.has_prior()) {
    settings.prior =
        read_prior(*message.mutable_prior(), path + ".prior", kinematics->layout().n_n(), problems);
  }
  if (problems.count() > before) return settings;
  try {
    core::require_rank(core::ProjectionModel(*kinematics, settings));
  } catch (const core::SceneError& error) {
    problems.wrong(path, "{ ... }", error.what());
  }
  return settings;
}

}  // namespace haptic::server
