#pragma once
/// A soft two-phalanx finger in the plane, closing on a soft cylinder held in the palm: the
/// simulation whose proxy the soft-grasp example streams.
///
/// Hand frame: origin at the MCP axis, +x distal, +y dorsal; m, rad; flexion positive, so that
/// phalanx k points along (cos a, -sin a), a = q1 for the proximal and q1 + q2 for the distal one.
/// Pads are points on the palmar side of each phalanx, each a spring of `pad_stiffness` while it is
/// inside the cylinder. With d_i(x) = max(0, radius - |p_i(x) - centre|) the proxy minimises
///   E(x) = 1/2 coupling |x - x_probe|^2 + 1/2 pad_stiffness sum_i d_i(x)^2,
/// the classical proxy (nearest to the probe) with soft constraints.

#include <array>
#include <vector>

#include "haptic/client/solve.hpp"

namespace haptic::examples {

using Joints = std::array<double, 2>;  ///< MCP, PIP; rad

struct SoftFingerModel {
  double proximal{0.045}, distal{0.040};     ///< phalanx lengths, m
  double pad_depth{0.008};                   ///< axis to palmar surface, m
  double pad_stiffness{400.0};               ///< N/m per point: pad and object in series
  double coupling{0.02};                     ///< N m/rad between probe and proxy
  double centre_x{0.045}, centre_y{-0.052};  ///< of the cylinder, m
  double radius{0.025};                      ///< m
};

class SoftFinger {
 public:
  static constexpr int kPadsPerPhalanx = 6;

  explicit SoftFinger(const SoftFingerModel& model = {}) : model_(model) {}

  /// The pads with a gap up to `horizon` (m) at x. A pad's number, from 1 on, is its id.
  [[nodiscard]] std::vector<client::Contact> pads(const Joints& x, double horizon) const;
  /// The same as the server takes them, to solve the same E(x) between two steps.
  [[nodiscard]] std::vector<client::Plane> contacts(const Joints& x, double horizon) const;
  /// Largest distance any pad is inside the cylinder; negative: the smallest clearance. m.
  [[nodiscard]] double depth(const Joints& x) const;

  struct Step {
    bool touching{false};
    Joints x{};  ///< the proxy; the probe itself if nothing touches
  };
  /// One simulation step. The finger starts open, outside the object, and goes to every probe in
  /// small pieces: wherever the simulation joins, and whatever the probe did while no state came,
  /// the proxy stays on the side that it came from. Contact ends only with a clearance of
  /// `kRelease`, so that noise does not toggle it.
  [[nodiscard]] Step step(const Joints& x_probe);

 private:
  static constexpr double kRelease = 0.0005;  // m
  static constexpr double kNear = 0.01;       // m; a piece reaches no farther
  static constexpr double kPiece = 0.05;      // rad; a pad moves 5 mm at most
  static constexpr double kFarthest = 6.3;    // rad; a probe that jumps farther is no finger's
  [[nodiscard]] Step follow(const Joints& x_probe);

  SoftFingerModel model_;
  bool touching_{false};
  Joints probe_{}, last_{};  ///< of the last step; open before the first
};

}  // namespace haptic::examples
