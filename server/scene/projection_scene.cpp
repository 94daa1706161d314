#include "server/scene/projection_scene.hpp"

#include "haptic/core/error.hpp"
#include "server/scene/field_reader.hpp"

namespace haptic::server {
namespace {

core::TaskMetric read_metric(v1::TaskMetricScene& message, const std::string& path, int n_x,
                             Problems& problems) {
  if (message.scale().empty() == message.matrix().empty()) {
    problems.missing(path, "one of scale, matrix");
    return {};
  }
  const FieldReader reader(message, path, problems);
  const std::size_t before = problems.count();
  const bool diagonal = message.matrix().empty();
  const std::vector<double> values =
      diagonal ? reader.list({"scale", Allowed::kPositive, n_x, "coordinate"})
               : reader.list(
                     {"matrix", Allowed::kFinite, n_x < 0 ? -1 : n_x * n_x, "pair of coordinates"});
  if (n_x < 0 || problems.count() > before) return {};
  try {
    if (diagonal) {
      return core::TaskMetric::from_scales(Eigen::Map<const Eigen::VectorXd>(values.data(), n_x));
    }
    return core::TaskMetric::from_matrix(
        Eigen::Map<const Eigen::MatrixXd>(values.data(), n_x, n_x).transpose());
  } catch (const core::SceneError& error) {
    problems.wrong(path, "{ ... }", error.what());
    return {};
  }
}

core::Prior read_prior(v1::PriorScene& message, const std::string& path, int n_n,
                       Problems& problems) {
  core::Prior prior;
  const FieldReader reader(message, path, problems);
  if (message.has_weight_per_j()) {
    reader.numbers({{"weight_per_j", &prior.weight, Allowed::kPositive}});
  } else {
    reader.missing("weight_per_j", "> 0, in 1/J");
  }
  const ListField field{"sensed_stiffness", Allowed::kPositive, n_n, "sensed DoF"};
  prior.sensed_stiffness =
      to_vector(n_n == 0 ? reader.list(field, std::vector<double>{}) : reader.list(field));
  return prior;
}

void check(const core::Kinematics& kinematics, const core::ProjectionSettings& settings,
           const std::string& path, Problems& problems) {
  if (settings.metric.is_identity() && kinematics.space().mixes_units()) {
    problems.missing(path + ".task_metric",
                     "{ scale: ... }, for x has coordinates in m and in rad and a distance over "
                     "both needs one");
    return;
  }
  try {
    core::require_rank(core::ProjectionModel(kinematics, settings));
  } catch (const core::SceneError& error) {
    problems.wrong(path + ".prior", settings.prior ? "{ ... }" : "[absent]", error.what());
  }
}

}  // namespace

core::ProjectionSettings read_projection(v1::DeviceScene& message, const std::string& path,
                                         const core::Kinematics* kinematics, Problems& problems) {
  core::ProjectionSettings settings;
  const std::size_t before = problems.count();
  if (message.has_task_metric()) {
    settings.metric = read_metric(*message.mutable_task_metric(), path + ".task_metric",
                                  kinematics == nullptr ? -1 : kinematics->space().n_x(), problems);
  }
  if (message.has_prior()) {
    settings.prior = read_prior(*message.mutable_prior(), path + ".prior",
                                kinematics == nullptr ? -1 : kinematics->layout().n_n(), problems);
  }
  if (kinematics != nullptr && problems.count() == before) {
    check(*kinematics, settings, path, problems);
  }
  return settings;
}

}  // namespace haptic::server
