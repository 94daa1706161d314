#pragma once
/// The contacts behind the proxy, as a rule that judges each of them reads them
/// (core/METHOD.md#rendering-per-contact).

#include "haptic/core/contacts/proxy_snapshot.hpp"

namespace haptic::core {

struct Contacts {
  PlaneSet::Normals into{};  ///< n_x by their number: direction in X that leads deeper, unit in W_x
  PlaneSet::Offsets depth{};  ///< how far the haptic probe is inside, in ||.||_W; <= 0: not

  [[nodiscard]] int size() const noexcept { return static_cast<int>(depth.size()); }
};

/// The contacts and limits of a part of a map.
struct ContactView {
  /// Null: a proxy without planes. Each displaced joint angle then counts as a contact, together
  /// with the angles that are displaced the other way, and other coordinates as one contact along
  /// dx (core/METHOD.md#rendering-per-contact).
  const Contacts* contacts{nullptr};
  const VecA* force_limit{nullptr};  ///< of the whole map; null: none
  int first_x{0};                    ///< the part's first coordinate
  int first_a{0};                    ///< and actuated DoF
};

}  // namespace haptic::core
