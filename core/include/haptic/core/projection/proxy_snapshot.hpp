#pragma once
/// The newest accepted sample of the proxy, and the planes of its local model
/// (core/METHOD.md#local-models): what the proxy may not pass between two samples.

#include <cstdint>
#include <tuple>

#include "haptic/core/time.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

enum class ProxyMode : std::uint8_t {
  kNone = 0,    ///< no proxy was ever accepted under this lease
  kHeld = 1,    ///< x stays where the sample put it until the next one
  kFree = 2,    ///< nothing in the way: no elastic force, no drag
  kPlanes = 3,  ///< x is the haptic probe, kept out of the sample's planes in every tick
};

/// Planes in one sample: a grasp by five fingers has ten contacts, one by a palm as well twenty.
inline constexpr int kMaxPlanes = 32;

/// n_i^T x <= b_i, linearised at the sample's own x. A normal is a covector: unit of b_i per unit
/// of each coordinate; its length is free (n and b may be scaled together).
struct PlaneSet {
  using Normals = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxX, kMaxPlanes>;
  using Offsets = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxPlanes, 1>;

  Normals normals{};  ///< n_x by number of planes, a normal per column
  Offsets offsets{};  ///< b, one per plane

  [[nodiscard]] int size() const noexcept { return static_cast<int>(offsets.size()); }

  [[nodiscard]] auto members() const noexcept { return std::tie(normals, offsets); }
};

/// The newest accepted proxy sample.
struct ProxySnapshot {
  ProxyMode mode{ProxyMode::kNone};
  std::uint32_t tenure{0};  ///< of the lease it was accepted under
  std::uint64_t seq{0};
  /// What its age is counted from: the local arrival, or earlier where a synchronised source time
  /// says so; never later.
  TimePoint born{};
  Duration valid_for{0};  ///< the client's own bound on its freshness; 0 = none given
  VecX x{};               ///< n_x; ignored in free mode; in planes mode where they are linearised
  PlaneSet planes{};      ///< planes mode; none: nothing in the way
  /// The stream's health, kept by the ingress for Engage (proto/README.md#a-session).
  TimePoint gapless_since{};         ///< first sample after the last gap longer than hold_end
  std::uint64_t gapless_samples{0};  ///< accepted since then

  [[nodiscard]] auto members() const noexcept {
    return std::tie(mode, tenure, seq, born, valid_for, x, planes, gapless_since, gapless_samples);
  }
};

}  // namespace haptic::core
