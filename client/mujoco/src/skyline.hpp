#pragma once
/// A symmetric positive definite matrix whose rows begin at their first entry, and equations
/// with it. Cholesky's factor keeps that shape, so little is done where objects touch few others.

#include <cstddef>
#include <vector>

namespace haptic::mujoco {

class Skyline {
 public:
  /// n rows of one zero each.
  void begin(std::size_t n);
  /// Row i has entries from column k on; before the first add().
  void reach(std::size_t i, std::size_t k);
  /// Adds to entry i, k <= i, which was reached.
  void add(std::size_t i, std::size_t k, double value) {
    if (entries_.empty()) allocate();
    row(i)[k] += value;
  }
  /// From here on it is its own factor.
  void factor();
  /// x = A^-1 x, after factor().
  void solve(std::vector<double>& x) const;

 private:
  void allocate();
  /// Row i, indexed by column: only those from first_[i] to i are there.
  [[nodiscard]] double* row(std::size_t i) { return entries_.data() + diagonal_[i] - i; }
  [[nodiscard]] const double* row(std::size_t i) const {
    return entries_.data() + diagonal_[i] - i;
  }

  std::vector<std::size_t> first_{}, diagonal_{};  ///< column; place in entries_
  std::vector<double> entries_{};
};

}  // namespace haptic::mujoco
