#pragma once
/// The contacts of one sample as the gaps that the proxy's problem reads (core/METHOD.md#contacts).
/// With y = x (-) the sample's own x (n_x) and t the sample's age in s, contact i has the gap
///   phi_i(y) = beta_i + speed_i t - a_i^T y,
/// scaled so that its gradient a_i has length 1 in W^-1: phi is a way in ||.||_W. A gap below 0
/// stores phi_i^2 / (2 gamma_i). A curved gap is the plane that touches it where linearise() was
/// last asked to. Never allocates after construction.

#include <array>
#include <vector>

#include "haptic/core/contacts/contact_laws.hpp"
#include "haptic/core/contacts/contacts.hpp"
#include "haptic/core/model/configuration_space.hpp"
#include "haptic/core/model/task_metric.hpp"

namespace haptic::core {

class ContactGaps {
 public:
  using Vector = ContactDual::Vector;
  /// Most by which curvature may turn and lengthen a gradient of length 1: beyond, the contact is
  /// the plane that touches it there.
  static constexpr double kMostTurn = 1.0;
  /// Coordinates from `first` on, and where their lower triangle begins, row by row.
  struct Curve {
    int first{0}, count{0}, begin{0};
  };

  /// `space` must outlive this. `metric`: W, of its n_x or the identity.
  ContactGaps(const ConfigurationSpace& space, TaskMetric metric);

  /// From now on these contacts, around `x` (n_x). A contact without a direction, or with a number
  /// that is not finite, is left out.
  void set(const PlaneSet& told, const VecX& x) noexcept;
  /// The object of contact i moves by a law, and not at the speed that was told.
  void stop(int i) noexcept { speed_[i] = 0.0; }
  /// The gap of contact i is `beta` at the sample's x: where the contacts are anchored.
  void shift(int i, double beta) noexcept { beta_[i] = beta; }
  /// linearise() begins with the gaps as they are now.
  void keep() noexcept;
  /// Curved contacts become the planes that touch them at y = z.
  void linearise(const VecX& z) noexcept;

  [[nodiscard]] const ConfigurationSpace& space() const noexcept { return *space_; }
  [[nodiscard]] const TaskMetric& metric() const noexcept { return metric_; }
  [[nodiscard]] int size() const noexcept { return count_; }
  /// Contacts as bits: those that are left out, and those that curve.
  [[nodiscard]] std::uint32_t left_out() const noexcept { return left_out_; }
  [[nodiscard]] bool leaves_out(int i) const noexcept { return ContactDual::has(left_out_, i); }
  [[nodiscard]] std::uint32_t curved() const noexcept { return curved_; }
  [[nodiscard]] bool is_curved(int i) const noexcept { return ContactDual::has(curved_, i); }
  [[nodiscard]] bool moving() const noexcept { return moving_; }
  [[nodiscard]] const Vector& beta() const noexcept { return beta_; }
  [[nodiscard]] const Vector& gamma() const noexcept { return gamma_; }
  [[nodiscard]] const Vector& speed() const noexcept { return speed_; }
  /// Length of each gradient as it was told, which its contact was divided by.
  [[nodiscard]] const Vector& length() const noexcept { return length_; }
  /// Each contact now by what it was at y = 0; 1 if it does not curve.
  [[nodiscard]] const Vector& scale() const noexcept { return scale_; }
  /// Column i: a_i now, and of a contact that curves a_i at y = 0; its beta_i there.
  [[nodiscard]] const PlaneSet::Normals& gradients() const noexcept { return A_; }
  [[nodiscard]] const PlaneSet::Normals& told_gradients() const noexcept { return told_.A; }
  [[nodiscard]] const Vector& told_beta() const noexcept { return told_.beta; }
  [[nodiscard]] const Curve& curve(int i) const noexcept {
    return curve_[static_cast<std::size_t>(i)];
  }
  /// The lower triangle of contact i, scaled.
  [[nodiscard]] const double* curvature(int i) const noexcept { return H_.data() + curve(i).begin; }
  /// From the first to the last coordinate that contact i names.
  [[nodiscard]] int breadth(int i) const noexcept { return rows_of(i).count; }
  /// Every contact's way in, and how deep it was in the last violations(); of one that is left out
  /// direction 0 and depth -1.
  [[nodiscard]] const Contacts& contacts() const noexcept { return contacts_; }

  /// y of a probe (n_x).
  void difference(const VecX& x_probe, VecX& y) const noexcept {
    space_->difference(x_probe, at_, y);
  }
  /// a_i^T v, v of n_x.
  [[nodiscard]] double along(int i, const double* v) const noexcept;
  /// v += l W^-1 a_i: how the multiplier l of contact i pushes.
  void push(VecX& v, double l, int i) const noexcept;
  /// r = -phi at y, the objects with a law where that is now. Returns the largest, or 0.
  double violations(const VecX& y, double age, const ContactLaws& laws, Vector& r) noexcept;
  /// The entries of A W^-1 A^T in which a contact of `changed` takes part.
  void multiply(std::uint32_t changed, ContactDual::Gram& products) const noexcept;
  /// x, until now the probe at y, pushed by the multipliers of the `held` contacts. A linear
  /// coordinate that none of them moves keeps its bits.
  void displace(const VecX& y, const Vector& l, std::uint32_t held, VecX& x) const noexcept;

 private:
  /// Coordinates in which a column is not 0: in a hand of many outputs few of them.
  struct Rows {
    int first{0}, count{0};
    [[nodiscard]] bool meet(Rows b) const noexcept {
      return first < b.first + b.count && b.first < first + count;
    }
  };
  [[nodiscard]] Rows rows_of(int i) const noexcept { return rows_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] Rows rows_into(int i) const noexcept {
    return metric_.is_diagonal() ? rows_of(i) : Rows{0, static_cast<int>(A_.rows())};
  }
  void take(const PlaneSet& told, int i) noexcept;
  void find_rows(int i) noexcept;
  /// Finds the contacts j <= i whose product with contact i may differ from 0.
  void find_meeting(int i) noexcept;
  /// Divides column i of A_ and of W^-1 A by its length, which is returned; 0: it has none.
  double normalise(int i) noexcept;

  const ConfigurationSpace* space_;
  TaskMetric metric_;
  std::vector<bool> linear_{};  ///< per coordinate: the real line, no turns and no signs
  int count_{0};
  std::uint32_t left_out_{0}, curved_{0};
  bool moving_{false};
  VecX at_;
  PlaneSet::Normals A_{};
  Contacts contacts_{};  ///< into: W^-1 A
  Vector beta_{}, gamma_{}, speed_{}, length_{}, scale_{};
  PlaneSet::Curvatures H_{};  ///< scaled
  std::array<Curve, kMaxPlanes> curve_{};
  std::array<Rows, kMaxPlanes> rows_{};  ///< of A_
  std::array<std::uint32_t, kMaxPlanes> meeting_{};
  /// At y = 0; columns of curved contacts.
  struct {
    PlaneSet::Normals A{}, into{};
    Vector beta{}, gamma{}, speed{};
  } told_{};
  VecX turn_{}, into_{};  ///< scratch
};

}  // namespace haptic::core
