#pragma once
/// The gap between a point and a round body (a plane, a cylinder, a sphere). Its gradient and its
/// second order tell it whole (core/METHOD.md#error-bound), if the coordinates are those of the
/// point itself, in m, or two parallel hinges, in rad; the first one carries the second.

#include <cstdint>

namespace haptic::core {

class RoundGap {
 public:
  enum class Moves : std::uint8_t { kUnknown, kPoint, kHinges };
  static constexpr int kMost = 3;  ///< coordinates

  RoundGap() = default;  ///< kUnknown: nothing follows
  /// `g` and `H`, a lower triangle row by row, of n coordinates, 2 or 3. kUnknown if they are not
  /// those of a round body, or those of several, or leave the hinges' place open.
  RoundGap(Moves moves, int n, const double* g, const double* H) noexcept;

  [[nodiscard]] Moves moves() const noexcept { return moves_; }
  /// Length of g.
  [[nodiscard]] double length() const noexcept { return length_; }
  /// From one hinge to the other, in the gap's unit.
  [[nodiscard]] double link() const noexcept { return length_ * link_; }

  /// Cosines and sines of what z turns the two links by.
  struct Turn {
    Turn() = default;
    explicit Turn(const double* z) noexcept;
    double cosine[2]{1.0, 1.0}, sine[2]{};
  };
  /// A law at z: by how much its gap is more than where it was told, and its gradient (n).
  struct Law {
    double gap;
    const double* gradient;
  };
  /// How far a law is from the body at z. There the most by which a way of length 1 turns the
  /// gradient, the third order, and the fourth on any way that times `grows` is at most 1.
  /// Lengths of z by ||g||, gradients by it.
  struct Off {
    double gap, gradient, bend;
    double third{0.0}, fourth{0.0}, grows{0.0};

    [[nodiscard]] double third_within(double way) const noexcept { return third + fourth * way; }
    [[nodiscard]] double bend_within(double way) const noexcept {
      return bend + way * (third + 0.5 * fourth * way);
    }
  };
  [[nodiscard]] Off point(const double* z, const Law& law) const noexcept;
  [[nodiscard]] Off hinges(const Turn& turn, const Law& law) const noexcept;

 private:
  /// Finds height_[1]. False: g and H do not tell it.
  [[nodiscard]] bool find_height() noexcept;
  /// curve_ by g and H; not finite: they are not those of one round body.
  [[nodiscard]] double curve_of_point() const noexcept;
  [[nodiscard]] double curve_of_hinges() const noexcept;
  /// The rest, by curve_ and height_[1].
  void place(Moves moves) noexcept;

  // With g of length 1:
  Moves moves_{Moves::kUnknown};
  int n_{0};
  double length_{1.0};  ///< of g
  double g_[kMost]{}, H_[kMost][kMost]{};
  double curve_{0.0};   ///< of the body; < 0: hollow
  double height_[2]{};  ///< of the point above each hinge, along the body's normal
  double link_{0.0};    ///< from one hinge to the other
  double reach_{1.0};   ///< most by which a turn of length 1 moves the point
};

}  // namespace haptic::core
