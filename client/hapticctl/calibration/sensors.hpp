#pragma once
/// What the calibration asks of a device: readings over a while.

#include <cstdint>
#include <string>
#include <vector>

namespace haptic::ctl {

/// Of everything that was read between begin() and end(). m or rad per DoF, N or N m per force.
struct Statistics {
  std::uint64_t samples{0};
  std::vector<double> mean{}, lowest{}, highest{};  ///< per DoF, as the sensors read it
  std::vector<double> force{};                      ///< means; empty: the device measures none
};

/// A device whose sensors are read on.
class Sensors {
 public:
  virtual ~Sensors() = default;
  Sensors(const Sensors&) = delete;
  Sensors& operator=(const Sensors&) = delete;

  virtual void begin() = 0;
  /// Of the readings since begin(). Throws where the device does not answer any more.
  [[nodiscard]] virtual Statistics end() = 0;
  /// The motors are off from now on: what the load cells read then is nothing but themselves. Until
  /// here they may give way at zero force, so that a hand can move the device.
  virtual void switch_off() = 0;
  /// Lets time pass.
  virtual void pause(double seconds) = 0;

 protected:
  Sensors() = default;
};

/// A DoF of the device, as ListDevices has it.
struct SensedDof {
  std::string name{}, unit{};
  double lower{0.0}, upper{0.0};
};

}  // namespace haptic::ctl
