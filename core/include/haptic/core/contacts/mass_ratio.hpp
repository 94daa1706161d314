#pragma once
/// The ratio of a pushed object's mass to the mass that its samples tell, learnt from the samples
/// (core/METHOD.md#pushed-objects). Two samples say by how much the object became faster. The law
/// that begins at the first one, replayed with the probes until the second one, says by how much it
/// should. Least squares over what was seen lately. Never allocates.

namespace haptic::core {

class MassRatio {
 public:
  /// The told mass is corrected by at most this factor.
  static constexpr double kMost = 4.0;

  /// One comparison, or the sum over an object's contacts of the same interval.
  struct Seen {
    double square{0.0};   ///< m x^2, x the change of velocity with the mass that was told
    double product{0.0};  ///< m x y, y the change between the two samples
    double told{0.0};     ///< m y^2
    double floor{0.0};    ///< m f^2, f by how much x may be wrong

    void add(double m, double x, double y, double f) noexcept {
      *this += {m * x * x, m * x * y, m * y * y, m * f * f};
    }
    void operator+=(const Seen& other) noexcept {
      square += other.square;
      product += other.product;
      told += other.told;
      floor += other.floor;
    }
  };
  /// `s`: how much time the comparison is of. What does not move the object teaches nothing, and
  /// nothing is forgotten meanwhile.
  void learn(const Seen& seen, double s) noexcept;
  /// Told mass by true mass, within 1 / kMost and kMost; 1 if nothing is known.
  [[nodiscard]] double value() const noexcept { return value_; }

 private:
  Seen sum_{};
  double value_{1.0};
};

}  // namespace haptic::core
