#include "server/scene/diagnostics_scene.hpp"

#include "server/scene/field_reader.hpp"

namespace haptic::server {

bool read_passivity_certificate(const v1::DeviceScene& message, const std::string& path,
                                Problems& problems) {
  if (message.has_passivity_certificate() && message.has_prior()) {
    problems.wrong(path + ".passivity_certificate", "{}",
                   "must be absent where there is a prior: it speaks of Eq. (8) without one");
  }
  return message.has_passivity_certificate();
}

std::optional<double> read_coupling_metric(v1::DeviceScene& message, const std::string& path,
                                           Problems& problems) {
  if (!message.has_coupling_metric()) return std::nullopt;
  v1::CouplingMetricScene& metric = *message.mutable_coupling_metric();
  const FieldReader reader(metric, path + ".coupling_metric", problems);
  double softness = 0.01;  // core/METHOD.md#anisotropic-coupling
  reader.numbers({{"softness", &softness, Allowed::kPositive}});
  if (softness > 1.0) reader.wrong("softness", decimal(softness), "must be at most 1");
  return softness;
}

}  // namespace haptic::server
