#include "server/scene/passivity_scene.hpp"

#include <algorithm>

#include "server/scene/field_reader.hpp"

namespace haptic::server {
namespace {

std::vector<double> values(const core::VecA& v) {
  return {v.data(), v.data() + v.size()};
}

std::vector<double> zeros(int n_a) {
  return std::vector<double>(static_cast<std::size_t>(std::max(n_a, 0)));
}

core::TankSettings read_tank(v1::EnergyTankScene& message, const std::string& path,
                             Problems& problems) {
  const FieldReader reader(message, path, problems);
  core::TankSettings tank;
  tank.enabled = true;
  reader.numbers({{"capacity_j", &tank.capacity, Allowed::kPositive},
                  {"initial_j", &tank.initial, Allowed::kNotNegative},
                  {"allowed_power_w", &tank.allowed_power, Allowed::kNotNegative}});
  if (tank.initial > tank.capacity) {
    reader.wrong("initial_j", decimal(tank.initial),
                 "must be at most capacity_j, " + decimal(tank.capacity));
  }
  return tank;
}

core::ObserverSettings read_observer(v1::PassivityObserverScene& message, const std::string& path,
                                     int n_a, const OwnDynamics& own, Problems& problems) {
  const FieldReader reader(message, path, problems);
  core::ObserverSettings observer;
  observer.enabled = true;
  reader.numbers({{"allowance_j", &observer.allowance, Allowed::kNotNegative},
                  {"forgetting_j", &observer.forgetting, Allowed::kNotNegative}});
  const ListField inertia{"inertia_kg", Allowed::kPositive, n_a, kPerActuatedDof};
  observer.inertia = to_vector(own.inertia.size() > 0 ? reader.list(inertia, values(own.inertia))
                                                      : reader.list(inertia));
  observer.slowest = to_vector(
      reader.list({"slowest_m_per_s", Allowed::kNotNegative, n_a, kPerActuatedDof}, zeros(n_a)));
  return observer;
}

}  // namespace

core::PassivitySettings read_passivity(v1::PassivityScene& message, const std::string& path,
                                       int n_a, const OwnDynamics& own, Problems& problems) {
  const FieldReader reader(message, path, problems);
  core::PassivitySettings settings;
  if (!message.has_tank() && !message.has_observer()) {
    problems.missing(path + ".tank", "tank {} or observer {}, or both");
  }
  if (message.has_tank()) {
    settings.tank = read_tank(*message.mutable_tank(), path + ".tank", problems);
  }
  if (message.has_observer()) {
    settings.observer =
        read_observer(*message.mutable_observer(), path + ".observer", n_a, own, problems);
  }
  settings.device_damping = to_vector(
      reader.list({"device_damping_n_s_per_m", Allowed::kNotNegative, n_a, kPerActuatedDof},
                  own.damping.size() > 0 ? values(own.damping) : zeros(n_a)));
  return settings;
}

}  // namespace haptic::server
