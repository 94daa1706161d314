#pragma once
/// Short vectors of core's types, as a test writes them.

#include "haptic/core/types.hpp"

namespace haptic {

inline core::VecA one(double value) {
  return core::VecA::Constant(1, value);
}
inline core::VecX two(double a, double b) {
  return (core::VecX(2) << a, b).finished();
}

}  // namespace haptic
