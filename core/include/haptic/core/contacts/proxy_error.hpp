#pragma once
/// How far the proxy that a simulation would find now may be from the one in use, by what its last
/// sample told (core/METHOD.md#error-bound), in ||.||_W.

#include "haptic/core/contacts/proxy_snapshot.hpp"

namespace haptic::core {

struct ProxyError {
  /// False: the sample is not anchored, or one of its contacts does not tell its uncertainty.
  bool known{false};
  double everywhere{0.0};  ///< what leads anywhere, as what the anchor left unexplained
  PlaneSet::Offsets of{};  ///< what each contact adds at most
  /// The contact along whose direction all of `of` lies; -1: in any direction.
  int along{-1};
  /// How far each contact's own depth may be off, and the end of its direction; size 0: not at all.
  PlaneSet::Offsets depth{}, turn{};
  /// Bit i: the probe may be inside of contact i, which does not hold x. Whether the simulation
  /// would tell it now depends on how far it looks ahead.
  std::uint32_t beside{0};

  /// Rounding of the proxy's problem.
  static constexpr double kNothing = 1e-9;
  [[nodiscard]] bool none() const noexcept {
    return everywhere < kNothing && (of.size() == 0 || of.isZero(kNothing));
  }
};

}  // namespace haptic::core
