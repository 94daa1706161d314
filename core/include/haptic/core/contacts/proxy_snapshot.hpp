#pragma once
/// The newest accepted sample of the proxy, and the planes of its local model
/// (core/METHOD.md#local-models): what the proxy may not pass between two samples.

#include <array>
#include <cstdint>
#include <tuple>

#include "haptic/core/time.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

enum class ProxyMode : std::uint8_t {
  kNone = 0,    ///< no proxy was ever accepted under this lease
  kHeld = 1,    ///< x stays until the next sample, but parts equal to the probe follow it
  kFree = 2,    ///< nothing in the way: no elastic force, no drag
  kPlanes = 3,  ///< x is the haptic probe, kept out of the sample's planes in every tick
};

/// Planes in one sample: a grasp by five fingers has ten contacts, one by a palm as well twenty.
inline constexpr int kMaxPlanes = 32;

/// Most coordinates that the curvature of one contact names: a finger has up to 4, a wrist 6.
inline constexpr int kMaxCurved = 8;
/// Most numbers of curvature in one sample: 32 contacts of fingers with 4 coordinates, or 8 with 8.
inline constexpr int kMaxCurvature = 320;

/// Most motions of an object that several contacts push: a body's translations and rotations.
inline constexpr int kMaxMotions = 6;

/// Contacts (core/METHOD.md#contacts). Contact i has at x, with z = x - the sample's own x and an
/// age of t seconds, the gap
///   phi_i(x) = b_i + v_i t - n_i^T x + 1/2 z^T H_i z,
/// which is >= 0 if the object is not touched. A normal is a covector: unit of b_i per unit of
/// each coordinate; its length is free (n, b, v, H may be scaled together, gamma by the square).
/// A plane, n_i^T x <= b_i, is a contact without compliance, velocity and curvature.
struct PlaneSet {
  using Normals = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxX, kMaxPlanes>;
  using Offsets = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxPlanes, 1>;
  using Curvatures = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxCurvature, 1>;
  using Places = std::array<std::uint8_t, kMaxPlanes>;
  /// A column per contact, all by the stiffness of the coupling: mass, damping, stiffness to ground
  /// and load, the force on the object besides the damping's and the contact's at the sample.
  using Laws = Eigen::Matrix<double, 4, Eigen::Dynamic, 0, 4, kMaxPlanes>;
  enum LawRow : std::uint8_t { kMass, kDamping, kStiffness, kLoad };
  /// A column per contact: the number of its object, 0: no other contact is on it, and below that
  /// the direction in which the contact pushes it, in the metric of the object's inertia.
  using Objects =
      Eigen::Matrix<double, 1 + kMaxMotions, Eigen::Dynamic, 0, 1 + kMaxMotions, kMaxPlanes>;

  /// Written out, or compilers clear all 24 KB of it.
  PlaneSet() noexcept : first{}, curved{} {}

  Normals normals{};  ///< n_x by number of planes, a normal per column
  Offsets offsets{};  ///< b, one per plane
  /// Laws of objects that are pushed (core/METHOD.md#pushed-objects): with u the unit of b, in
  /// s^2/u^2, s/u^2, 1/u^2 and 1/u. Mass 0: none.
  Laws laws{};
  Offsets ids{};      ///< what names a contact with a law from sample to sample; 0: nothing
  Objects objects{};  ///< of size 0 if no two contacts push one object
  /// H, contact after contact: the lower triangle, row by row.
  Curvatures curvature{};
  Places first, curved;  ///< the coordinates that each H names: the first one, and how many

  /// Numbers in a lower triangle of n rows.
  [[nodiscard]] static constexpr int triangle(int n) noexcept { return n * (n + 1) / 2; }
  [[nodiscard]] int size() const noexcept { return static_cast<int>(offsets.size()); }
  /// Sizes fit each other and n_x, and every number is finite.
  [[nodiscard]] bool fits(int n_x) const noexcept;

  // lists(): one number per plane each, or of size 0 if no contact has it. `compliance` is gamma in
  // (unit of b)^2 of ||.||_W, `velocity` is v. `uncertainty` is of size 0 too if one of the
  // contacts does not say it; 0: gamma is exact.
#include "haptic/core/contacts/plane_lists.inc"
};

/// Samples do not count as fresh, because more than twice as many come as were announced; zeros:
/// they do.
struct StreamRate {
  double comes_hz{0.0}, announced_hz{0.0};
};

/// The newest accepted proxy sample.
struct ProxySnapshot {
  ProxyMode mode{ProxyMode::kNone};
  std::uint32_t tenure{0};  ///< of the lease it was accepted under
  std::uint64_t seq{0};
  /// The time from which its age is counted: the local arrival, or earlier if a synchronised
  /// source time says so; never later.
  TimePoint born{};
  /// When its contacts were true, by the best estimate of the source's clock; TimePoint{}: not
  /// known, `born` counts. Moves the contacts that have a velocity, at most until hold_end.
  TimePoint computed{};
  Duration valid_for{0};  ///< the client's own bound on its freshness; 0 = none given
  VecX x{};               ///< n_x; ignored in free mode; in planes mode where they are linearised
  PlaneSet planes{};      ///< planes mode; none: nothing in the way
  /// Tick of whose x_probe the simulation computed x, and with it the contacts; they are anchored
  /// there. 0: they are taken as they were told.
  std::uint64_t anchored_at{0};
  /// The same of a sample in any mode: how old its answer is, and of a held one where it was free;
  /// 0: not told.
  std::uint64_t seen_at{0};
  /// The stream's health, kept by the ingress for Engage (proto/README.md#a-session).
  TimePoint gapless_since{};         ///< first sample after the last gap longer than hold_end
  std::uint64_t gapless_samples{0};  ///< accepted since then
  StreamRate too_fast{};
};

}  // namespace haptic::core
