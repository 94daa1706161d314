#pragma once
/// The dual of the proxy against planes and contacts (core/METHOD.md#contacts):
///   l = argmin 1/2 l^T (G + Gamma + eps) l - l^T r   over l >= 0,
/// G the Gram matrix of the gradients, Gamma the diagonal of the compliances, r the violations at
/// the haptic probe. C. L. Lawson and R. J. Hanson's active set, warm from the l that is there.
/// eps makes every set of contacts have one answer; it is iterated away if they can all be met. The
/// work is bounded: after kMostSolves systems of equations, which only planes that contradict each
/// other by the dozen need, what was reached is the answer. Never allocates.

#include "haptic/core/projection/proxy_snapshot.hpp"

namespace haptic::core {

class ContactDual {
 public:
  using Vector = Eigen::Matrix<double, kMaxPlanes, 1>;
  using Gram = Eigen::Matrix<double, kMaxPlanes, kMaxPlanes, Eigen::RowMajor>;
  /// eps, relative to the dual's unit diagonal: large against rounding, small against any wedge
  /// that a simulation has.
  static constexpr double kEpsilon = 1e-10;

  /// Bit i of a set of contacts.
  [[nodiscard]] static constexpr bool has(std::uint32_t set, int i) noexcept {
    return (set >> i & 1u) != 0;
  }

  /// From now on `count` contacts; those in `left_out`, as bits, are never held.
  void begin(int count, std::uint32_t left_out) noexcept;
  /// G + Gamma + eps, symmetric, of the first `count` rows and columns. After a change: refactor().
  [[nodiscard]] Gram& gram() noexcept { return G_; }
  void refactor() noexcept { factored_ = 0; }
  void hold_none() noexcept;

  /// The answer with eps.
  void solve(const Vector& r) noexcept;
  /// The answer for eps = 0, for violations r, the deepest of them > 0. False: rigid contacts
  /// contradict each other, and l gives the least violation.
  [[nodiscard]] bool meet(const Vector& r, double deepest) noexcept;

  /// > 0 for the contacts held, else 0.
  [[nodiscard]] const Vector& l() const noexcept { return l_; }
  [[nodiscard]] std::uint32_t held() const noexcept { return active_; }

 private:
  static constexpr int kMostSolves = 3 * kMaxPlanes;

  void solve(const Vector& r, int& left) noexcept;
  /// Goes from l_ towards the solution on the contacts held, which lose those that it would make <
  /// 0.
  void settle(const Vector& r, double largest, int& left) noexcept;
  /// s = G_^-1 r on the contacts held, in their order.
  void solve_held(const Vector& r, Vector& s) noexcept;
  /// G_ l_ at contact i.
  [[nodiscard]] double pushed(int i) const noexcept;

  int count_{0};
  std::uint32_t left_out_{0};
  Gram G_{};
  Vector l_{};
  int held_[kMaxPlanes]{};  ///< in the order in which they came
  int n_held_{0};
  Gram L_{};         ///< of Cholesky, in that order
  int factored_{0};  ///< rows of L_ that hold
  std::uint32_t active_{0};
};

}  // namespace haptic::core
