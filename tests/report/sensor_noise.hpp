#pragma once
/// Sensors of a device between the physics and the pipeline: noise and resolution of each DoF.

#include <CLI/CLI.hpp>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "haptic/core/model/kinematics.hpp"
#include "hw/random.hpp"
#include "tests/report/values.hpp"

namespace haptic::report {

/// Each for a DoF in m / in rad. Range: that of the DoF.
enum class SensorNoise {
  kNone,
  kScene,      ///< of the shipped scene finger_soft_grasp: 2 um, 0.2 mrad rms
  kPot12,      ///< potentiometer on a converter of 12 bits over the range, with the noise that is
               ///< left of a SINAD of 72 dB: 0.22 quanta rms (Microchip MCP3208, data sheet)
  kEncoder14,  ///< magnetic encoder of 14 bits a turn with at most 0.06 deg rms (ams AS5048A, data
               ///< sheet); a DoF in m turns it once over its range
  kRough,      ///< 5 um, 0.05 deg rms
};
inline constexpr std::array<SensorNoise, 5> kSensorNoises{
    SensorNoise::kNone, SensorNoise::kScene, SensorNoise::kPot12, SensorNoise::kEncoder14,
    SensorNoise::kRough};
[[nodiscard]] inline std::string_view name(SensorNoise noise) noexcept {
  return name_in({"none", "scene", "pot_12_bit", "encoder_14_bit", "5um_0.05deg"}, noise);
}
/// The one of that name, or none.
[[nodiscard]] SensorNoise sensor_noise(const std::string& name) noexcept;

/// --noise.
inline void add_noise(CLI::App& command, std::string& to, const std::string& help) {
  std::vector<std::string> names;
  for (const SensorNoise noise : kSensorNoises) names.emplace_back(name(noise));
  command.add_option("--noise", to, help)->check(CLI::IsMember(names));
}

class Sensors {
 public:
  Sensors(SensorNoise noise, const core::Kinematics& map, std::uint64_t seed);
  /// The reading of q, n_q.
  [[nodiscard]] core::VecQ read(core::VecQ q);

 private:
  struct Dof {
    double sigma{0.0}, quantum{0.0};
  };
  std::vector<Dof> dofs_{};
  hw::Gaussian gaussian_;
};

}  // namespace haptic::report
