#pragma once
/// The constraints of mechanisms (Kinematics::mechanisms: the ends of sliders, the branch of
/// core/METHOD.md#inverse-map) in the iteration behind Eq. (6). If steps that
/// break them were rejected instead, the iteration would stall (core/METHOD.md#worst-cases).
///
/// If a linear step would break a limit, that limit is *engaged*: the two DoFs of its pair are
/// replaced by one across the limit and one along it, so that the limit is a bound like those of
/// the box. The way along it ends at the pair's other limits. After the step the pair is put back
/// onto the limits' curves, so that every iterate keeps them.

#include <array>
#include <limits>
#include <span>

#include "haptic/core/linear/boxed_least_squares.hpp"
#include "haptic/core/model/kinematics.hpp"

namespace haptic::core {

class MechanismLimits {
 public:
  /// `kinematics` must outlive this. A map without pairs costs nothing.
  explicit MechanismLimits(const Kinematics& kinematics);

  /// True if no limit can be broken between q and q + p, because both are near the q of the last
  /// look(); always true without pairs. For most warm steps this is the only cost.
  [[nodiscard]] bool apart(const VecQ& q, const VecQ& p) const noexcept;
  /// True if a limit is engaged.
  [[nodiscard]] bool engaged() const noexcept;
  /// Prepares a step from q: evaluates its limits and engages none.
  void look(const VecQ& q) noexcept;
  /// For each pair with an engaged limit: turns its columns, bounds (of the step, holding 0) and
  /// entries of `metric_root` (see BoxedLeastSquares::solve).
  void turn(BoxedLeastSquares& linear, VecQ& lower, VecQ& upper, VecQ& metric_root) noexcept;
  /// The step in q for one in turned DoFs.
  void turn_back(VecQ& p) noexcept;
  /// For each pair: engages the limit that the step breaks most. If a limit is engaged already, and
  /// the step leaves it and is stopped by another, changes to that one, once. True if any was
  /// engaged or changed.
  bool engage(const VecQ& p) noexcept;
  /// Moves each pair of q, within its box, onto the limits that it breaks. False if that does not
  /// succeed, or the mechanism has no pose there.
  [[nodiscard]] bool restore(VecQ& q) const noexcept;

 private:
  static constexpr int kBox = 4;  ///< limits that are the box's
  static constexpr int kOwn = static_cast<int>(std::tuple_size_v<Constraints>);
  using All = std::array<Constraint, kOwn + kBox>;  ///< the mechanism's, then the box's
  /// Bounds of a step in turned DoFs, in widths.
  struct Bounds {
    double nearest{0.0}, farthest{std::numeric_limits<double>::infinity()};
    double back{-std::numeric_limits<double>::infinity()};
    double on{std::numeric_limits<double>::infinity()};
    double slant{0.0};               ///< along, per width across
    int ends_back{-1}, ends_on{-1};  ///< limits that set `back` and `on`
  };
  struct Pair {
    const Kinematics* mechanism{nullptr};
    int first{0};
    double lower[2]{}, upper[2]{}, width[2]{};
    double seen[2]{};    ///< DoFs at the last look()
    double reach{-1.0};  ///< distance from `seen` without a limit, in widths; < 0: none known
    All limits{};        ///< there
    int engaged{-1};     ///< of `limits`
    double across[2]{};  ///< unit vector in widths: the way off the engaged limit
    double way[2]{};     ///< the way onto it, likewise: past the pair's other limits
    Bounds bounds{};
    int blocked_by{-1};     ///< of `limits`
    bool changed{false};    ///< `engaged` is not the first
    double steepness{0.0};  ///< room gained per width across
  };
  [[nodiscard]] static Bounds bounds_of(const Pair& pair) noexcept;
  [[nodiscard]] static double reach_of(const Pair& pair) noexcept;
  static void lead(Pair& pair, int limit) noexcept;
  /// The mechanism's limits and the box's at (a, b); false if there is no pose.
  [[nodiscard]] bool limits_at(const Pair& pair, double a, double b, All& all) const noexcept;
  [[nodiscard]] bool restore(const Pair& pair, double& a, double& b) const noexcept;

  [[nodiscard]] std::span<Pair> pairs() noexcept { return {pairs_.data(), count_}; }
  [[nodiscard]] std::span<const Pair> pairs() const noexcept { return {pairs_.data(), count_}; }

  std::size_t count_{0};
  std::array<Pair, kMaxQ / 2> pairs_{};  ///< in place: a renderer is changed under way
};

}  // namespace haptic::core
