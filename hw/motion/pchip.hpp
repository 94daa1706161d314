#pragma once
/// Piecewise cubic Hermite interpolation that keeps the shape of the data: between two knots the
/// curve stays between their values, so that interpolating a recording adds no overshoot and stays
/// within the range of the rows.
/// Source: F. N. Fritsch, R. E. Carlson, SIAM J. Numer. Anal. 17(2):238-246, 1980; slopes by the
/// weighted harmonic mean of F. N. Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5(2):300-304,
/// 1984.

#include <cstddef>
#include <vector>

namespace haptic::hw {

class Pchip {
 public:
  /// `t` strictly increasing, at least one knot; `y` of the same size.
  Pchip(std::vector<double> t, std::vector<double> y);

  /// Value at `at`; the end values outside [first(), last()]. Allocates nothing; O(log n).
  [[nodiscard]] double operator()(double at) const noexcept { return (*this)(place(at)); }

  /// Where `at` lies among the knots: for the values there of several curves with the same knots.
  struct Place {
    std::size_t interval{0};
    double length{0.0}, share{0.0};  ///< of the interval, and the share of it that is behind
  };
  [[nodiscard]] Place place(double at) const noexcept;
  [[nodiscard]] double operator()(const Place& place) const noexcept;

  /// Index i of the knots i, i + 1 around `at`; the outermost ones beyond the ends. Two knots or
  /// more.
  [[nodiscard]] std::size_t interval(double at) const noexcept;

  [[nodiscard]] double first() const noexcept { return t_.front(); }
  [[nodiscard]] double last() const noexcept { return t_.back(); }

 private:
  std::vector<double> t_;
  std::vector<double> y_;
  std::vector<double> slope_;  ///< dy/dt at the knots
};

}  // namespace haptic::hw
