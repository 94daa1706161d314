#pragma once
/// The dual of the proxy against planes and contacts (core/METHOD.md#contacts):
///   l = argmin 1/2 l^T (G + Gamma + eps) l - l^T r   over l >= 0,
/// G the Gram matrix of the gradients, Gamma the diagonal of the compliances, r the violations at
/// the haptic probe. C. L. Lawson and R. J. Hanson's active set, warm from the l that is there.
/// eps, of contacts whose own compliance is less, makes every set have one answer, which is
/// iterated on in kProximal steps. The work is bounded: if what allow() granted is spent, which
/// takes dozens of contacts, what was reached is the answer, and the next call goes on from there.
/// Never allocates.

#include <algorithm>

#include "haptic/core/contacts/proxy_snapshot.hpp"

namespace haptic::core {

class ContactDual {
 public:
  using Vector = Eigen::Matrix<double, kMaxPlanes, 1>;
  using Gram = Eigen::Matrix<double, kMaxPlanes, kMaxPlanes, Eigen::RowMajor>;
  /// eps, relative to the dual's unit diagonal: large against rounding, small against any wedge
  /// that a simulation has.
  static constexpr double kEpsilon = 1e-6;
  static constexpr int kProximal = 12;
  /// Contacts that give way to each other, by root_i root_j cosine_ij per l_j.
  struct Gives {
    std::uint32_t contacts{0};
    Vector root{};
    const Gram* cosine{nullptr};  ///< symmetric
  };

  /// Bit i of a set of contacts.
  [[nodiscard]] static constexpr bool has(std::uint32_t set, int i) noexcept {
    return (set >> i & 1u) != 0;
  }

  /// From now on `count` contacts; those in `left_out`, as bits, are never held.
  void begin(int count, std::uint32_t left_out) noexcept;
  /// The part of G that is A W^-1 A^T, symmetric, of the first `count` rows and columns. After a
  /// change: give().
  [[nodiscard]] Gram& products() noexcept { return products_; }
  /// The rest of G; null: there is none. The cosines must stay.
  void give(const Gives* gives) noexcept;
  /// Entry (i, i) of G + Gamma + eps, from G's and Gamma's.
  void set_diagonal(int i, double square, double give) noexcept;
  /// The same with what stands in for Gamma + eps.
  void put_diagonal(int i, double value) noexcept {
    diagonal_[i] = value;
    factored_ = 0;
  }
  /// The next solve() leaves these contacts out. None of them is held.
  void leave_out(std::uint32_t contacts) noexcept { left_out_ = contacts; }
  void hold_none() noexcept;
  /// The next answer is looked for from this l (>= 0) on.
  void begin_at(const Vector& l) noexcept;
  /// From here on that many multiplications may be spent, and once the system at which they end.
  void allow(int multiplications) noexcept { left_ = granted_ = multiplications; }
  /// Multiplications that allow() granted last, and how many are left.
  [[nodiscard]] int spent() const noexcept { return granted_ - left_; }
  [[nodiscard]] int left() const noexcept { return std::max(0, left_); }

  /// The answer with eps.
  void solve(const Vector& r) noexcept;
  /// The answer for eps = 0, for violations r, the deepest of them > 0. False: rigid contacts
  /// contradict each other, and l gives the least violation.
  [[nodiscard]] bool meet(const Vector& r, double deepest) noexcept;

  /// > 0 for the contacts held, else 0.
  [[nodiscard]] const Vector& l() const noexcept { return l_; }
  [[nodiscard]] std::uint32_t held() const noexcept { return active_; }

 private:
  /// Goes from l_ towards the solution on the contacts held, which lose those that it would make <
  /// 0.
  void settle(const Vector& r, double largest) noexcept;
  /// s = (G + Gamma + eps)^-1 r on the contacts held, in their order.
  void solve_held(const Vector& r, Vector& s) noexcept;
  /// Row i of G, but for the diagonal.
  [[nodiscard]] Gram::ConstRowXpr row(int i) noexcept;

  int count_{0};
  int left_{0}, granted_{0};
  std::uint32_t left_out_{0};
  Gram products_{};
  Gives gives_{};
  Gram sums_{};              ///< products_ and gives_
  std::uint32_t summed_{0};  ///< rows of these that hold
  Vector diagonal_{}, eps_{};
  Vector l_{};
  int held_[kMaxPlanes]{};  ///< in the order in which they came
  int n_held_{0};
  Gram L_{};  ///< of Cholesky, in that order, but for the diagonal
  Eigen::Matrix<double, kMaxPlanes, kMaxPlanes> columns_{};  ///< the same, by columns
  Vector inverse_{};                                         ///< 1 by its diagonal
  int factored_{0};                                          ///< rows of L that hold
  std::uint32_t active_{0};
};

}  // namespace haptic::core
