#pragma once
/// The map f : Q -> X of a device (paper, section III), its Jacobian, and the inverse if there is a
/// closed form. Immutable after construction; one object may be shared by threads. No method but
/// drawing() allocates or throws after construction.

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "haptic/core/model/configuration_space.hpp"
#include "haptic/core/model/dof_layout.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

enum class MapStatus : std::uint8_t {
  kOk,
  kCannotClose,  ///< the linkage has no configuration at this q
                 ///< (core/METHOD.md#map-without-a-value)
};

enum class InverseStatus : std::uint8_t {
  kExact,        ///< f(q) = x, inside the box and the slider limits
  kUnreachable,  ///< q is the nearest that the box and the slider limits allow, argmin ||x - f(q)||
  kNotOffered,   ///< this map has no closed-form inverse; q untouched
};

/// A DoF of q as the map knows it.
struct DofSpec {
  std::string name{};
  Unit unit{Unit::kMetre};
  bool actuated{false};
  double lower{0.0};  ///< box of q*, m or rad
  double upper{0.0};
};

/// S of these DoFs. Throws SceneError: none or more than kMaxQ, or none actuated.
[[nodiscard]] DofLayout layout_of(const std::vector<DofSpec>& dofs);

/// A constraint on the DoFs of a mechanism besides their box, such as the end of a slider: it holds
/// while room >= 0.
struct Constraint {
  double room{std::numeric_limits<double>::infinity()};  ///< of any unit
  double gradient[2]{};  ///< d room / dq; 0 if the constraint is out of a step's reach
};
/// Constraints of a mechanism; those that it lacks stay as they are made. A finger has both ends of
/// two sliders, and the branch (core/METHOD.md#inverse-map).
using Constraints = std::array<Constraint, 5>;

/// Which of a map's independent blocks: bit i stands for the i-th of Kinematics::blocks(). A map
/// without blocks counts as one block.
using BlockSet = std::uint32_t;

class Kinematics;
struct Drawing;  // drawing.hpp

/// An independent part of a map, such as a finger of a hand: its coordinates depend on its own DoFs
/// only, so that J is block diagonal.
struct MapBlock {
  const Kinematics* kinematics{nullptr};  ///< lives as long as the map it is a part of
  int first_q{0};                         ///< index in q of its first DoF
  int first_a{0};                         ///< index in q_a of its first actuated DoF
  int first_x{0};                         ///< index in x of its first coordinate

  [[nodiscard]] int n_q() const noexcept;
  [[nodiscard]] int n_a() const noexcept;
  [[nodiscard]] int n_x() const noexcept;
};

/// A mechanism stands between two DoFs, which follow each other in q, and the joints that they
/// turn. It is a map of its own: a finger, also of a hand.
struct Mechanism {
  const Kinematics* kinematics{nullptr};  ///< lives as long as the map it is a part of
  int first_q{0};                         ///< index in q of its first DoF
};

class Kinematics {
 public:
  virtual ~Kinematics() = default;
  Kinematics(const Kinematics&) = delete;
  Kinematics& operator=(const Kinematics&) = delete;

  [[nodiscard]] const DofLayout& layout() const noexcept { return layout_; }
  [[nodiscard]] const std::vector<DofSpec>& dofs() const noexcept { return dofs_; }
  [[nodiscard]] const ConfigurationSpace& space() const noexcept { return space_; }

  /// x_probe = f(q) and J = dx_probe/dq (n_x by n_q). On kCannotClose both are untouched.
  [[nodiscard]] virtual MapStatus evaluate(const VecQ& q, VecX& x_probe,
                                           MatXQ& J) const noexcept = 0;
  /// f(q) alone, the same bits as evaluate() writes; untouched on kCannotClose. A map for which
  /// this is cheaper than evaluate() overrides it.
  [[nodiscard]] virtual MapStatus position(const VecQ& q, VecX& x_probe) const noexcept;
  /// q = argmin ||x - f(q)|| over the box and the device's own constraints, stateless: Eq. (6).
  [[nodiscard]] virtual InverseStatus inverse(const VecX& /*x*/, VecQ& /*q*/) const noexcept {
    return InverseStatus::kNotOffered;
  }
  /// The mechanisms in this map that have constraints, in the order of q; none: the box of dofs()
  /// says all.
  [[nodiscard]] virtual std::span<const Mechanism> mechanisms() const noexcept { return {}; }
  /// The constraints of a map that is such a mechanism, at its q. kCannotClose: it has no pose
  /// there.
  [[nodiscard]] virtual MapStatus constraints(const VecQ& /*q*/,
                                              Constraints& /*out*/) const noexcept {
    return MapStatus::kCannotClose;
  }
  /// The independent parts of this map, in the order of q, q_a and x, covering all of them; empty
  /// if it has no such parts. Each part can be projected by itself
  /// (core/METHOD.md#model-only-what-a-scene-needs: one finger at a time).
  [[nodiscard]] virtual std::span<const MapBlock> blocks() const noexcept { return {}; }
  /// Several q may mean the same pose (a rotation vector has many); replaces q by the one nearest
  /// to `near`. Most maps have one q per pose, and this does nothing.
  virtual void nearest_representative(const VecQ& /*near*/, VecQ& /*q*/) const noexcept {}
  /// The device as bodies that move, for a picture of it; without bodies: it has none. Not for the
  /// loop: it allocates.
  [[nodiscard]] virtual Drawing drawing() const;
  /// Mean of ||J_a|| (Frobenius) over the reachable workspace: the scale that the paper's Z_x
  /// factors out (section VI.C).
  [[nodiscard]] double mean_actuated_jacobian() const noexcept { return mean_J_a_; }

 protected:
  /// Throws SceneError as layout_of() does.
  Kinematics(std::vector<DofSpec> dofs, ConfigurationSpace space)
      : dofs_(std::move(dofs)), layout_(layout_of(dofs_)), space_(std::move(space)) {}

  const std::vector<DofSpec> dofs_;
  const DofLayout layout_;
  const ConfigurationSpace space_;
  double mean_J_a_{1.0};  ///< the map's constructor sets it
};

/// blocks(), or the whole map as one.
[[nodiscard]] std::vector<MapBlock> blocks_or_whole(const Kinematics& kinematics);

/// The i-th point of the Halton sequence (i >= 0) in the box of q. n_q values, m or rad. The same
/// in every run, so that a scene loads equally everywhere. For set-up only.
[[nodiscard]] VecQ workspace_sample(const Kinematics& kinematics, int i);

/// ||J_a|| (Frobenius): of the columns of actuated DoFs.
[[nodiscard]] double actuated_norm(const MatXQ& J, const DofLayout& layout) noexcept;
/// Mean of that over 256 such points; 0 if f has no value at any of them.
/// For set-up only.
[[nodiscard]] double mean_actuated_jacobian(const Kinematics& kinematics);

inline int MapBlock::n_q() const noexcept {
  return kinematics->layout().n_q();
}
inline int MapBlock::n_a() const noexcept {
  return kinematics->layout().n_a();
}
inline int MapBlock::n_x() const noexcept {
  return kinematics->space().n_x();
}

}  // namespace haptic::core
