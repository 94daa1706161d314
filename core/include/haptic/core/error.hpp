#pragma once
/// Errors that set-up throws, by reason. A message says what is wrong, the value, what is allowed,
/// where: `impedance.stiffness_n_per_m[0] = -3: must be > 0`. Cyclic code returns enums and never
/// throws.

#include <cmath>
#include <stdexcept>
#include <string>

namespace haptic::core {

class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A scene that cannot be loaded, or a setting it does not allow.
class SceneError : public Error {
 public:
  using Error::Error;
};

/// Throws SceneError "NAME = VALUE: must be finite and RULE" unless `holds` and the value is
/// finite; without a rule it must only be finite.
inline void require(bool holds, const std::string& name, double value,
                    const std::string& rule = "") {
  if (holds && std::isfinite(value)) return;
  throw SceneError(name + " = " + std::to_string(value) + ": must be finite" +
                   (rule.empty() ? "" : " and " + rule));
}

/// A device that cannot be opened, or a recording that cannot be read.
class DeviceError : public Error {
 public:
  using Error::Error;
};

/// Real-time scheduling or memory locking refused although it was required.
class RealtimeError : public Error {
 public:
  using Error::Error;
};

/// An address that cannot be served or reached.
class TransportError : public Error {
 public:
  using Error::Error;
};

}  // namespace haptic::core
