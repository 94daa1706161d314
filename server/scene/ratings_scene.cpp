#include "server/scene/ratings_scene.hpp"

#include <algorithm>

#include "server/scene/field_reader.hpp"

namespace haptic::server {
namespace {

/// A list that may be absent altogether.
std::vector<double> list_or_none(const FieldReader& reader, const char* name, int given, int n_a) {
  if (given == 0) return {};
  return reader.list({name, Allowed::kPositive, n_a, kPerActuatedDof});
}

core::ThermalParameters read_thermal(v1::ThermalScene& message, const std::string& path,
                                     Problems& problems) {
  const FieldReader reader(message, path, problems);
  core::ThermalParameters p;
  const std::size_t before = problems.count();
  const auto required = [&](const char* name, bool given, double& value) {
    if (!given) return problems.missing(path + "." + name, "a number > 0");
    reader.numbers({{name, &value, Allowed::kPositive}});
  };
  required("motor_constant", message.has_motor_constant(), p.motor_constant);
  required("winding_k_per_w", message.has_winding_k_per_w(), p.winding_resistance);
  required("winding_time_s", message.has_winding_time_s(), p.winding_time);
  required("limit_c", message.has_limit_c(), p.limit_c);
  reader.numbers({{"housing_k_per_w", &p.housing_resistance, Allowed::kNotNegative},
                  {"housing_time_s", &p.housing_time, Allowed::kPositive},
                  {"ambient_c", &p.ambient_c, Allowed::kFinite}});
  p.derate_from_c = p.limit_c - 0.25 * (p.limit_c - p.ambient_c);
  reader.numbers({{"derate_from_c", &p.derate_from_c, Allowed::kFinite}});
  if (problems.count() > before) return p;
  if (p.limit_c <= p.ambient_c) {
    reader.wrong("limit_c", decimal(p.limit_c), "must be above ambient_c, " + decimal(p.ambient_c));
  } else if (p.derate_from_c <= p.ambient_c || p.derate_from_c >= p.limit_c) {
    reader.wrong("derate_from_c", decimal(p.derate_from_c),
                 "must be above ambient_c, " + decimal(p.ambient_c) + ", and below limit_c, " +
                     decimal(p.limit_c));
  }
  return p;
}

}  // namespace

std::vector<core::ActuatorRatings> read_ratings(v1::LimitsScene& message, const std::string& path,
                                                int n_a, Problems& problems) {
  const FieldReader reader(message, path, problems);
  const auto power = list_or_none(reader, "power_w", message.power_w_size(), n_a);
  const auto rate = list_or_none(reader, "rate_m_per_s", message.rate_m_per_s_size(), n_a);
  const int thermals = message.thermal_size();
  if (thermals != 0 && n_a >= 0 && thermals != n_a) {
    reader.wrong("thermal", std::to_string(thermals) + " of them",
                 "must be one per actuated DoF, " + std::to_string(n_a) + ", or none");
  }
  const auto entries = static_cast<std::size_t>(
      std::max({static_cast<int>(power.size()), static_cast<int>(rate.size()), thermals}));
  std::vector<core::ActuatorRatings> ratings(entries);
  for (std::size_t i = 0; i < entries; ++i) {
    if (i < power.size()) ratings[i].power = power[i];
    if (i < rate.size()) ratings[i].rate = rate[i];
    if (static_cast<int>(i) >= thermals) continue;
    ratings[i].thermal = read_thermal(*message.mutable_thermal(static_cast<int>(i)),
                                      path + ".thermal[" + std::to_string(i) + "]", problems);
  }
  return ratings;
}

}  // namespace haptic::server
