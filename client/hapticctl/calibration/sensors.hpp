#pragma once
/// A device as the calibration sees it: readings over a time.

#include <cstdint>
#include <vector>

namespace haptic::ctl {

/// Statistics of the readings between begin() and end(); m or rad per DoF, N or N m per force.
struct Statistics {
  std::uint64_t samples{0};
  std::vector<double> mean{}, lowest{}, highest{};  ///< per DoF, as the sensors read it
  std::vector<double> force{};                      ///< means; empty: the device measures no force
};

/// A device whose sensors are read continuously.
class Sensors {
 public:
  virtual ~Sensors() = default;
  Sensors(const Sensors&) = delete;
  Sensors& operator=(const Sensors&) = delete;

  virtual void begin() = 0;
  /// Statistics since begin(). Throws if the device no longer answers.
  [[nodiscard]] virtual Statistics end() = 0;
  /// Switches the motors off, so that the load cells read nothing but their own offset. Before, the
  /// motors may be on at zero force, so that a hand can move the device.
  virtual void switch_off() = 0;
  /// Lets time pass.
  virtual void pause(double seconds) = 0;

 protected:
  Sensors() = default;
};

}  // namespace haptic::ctl
