#include "finger_linkage.hpp"

#include <algorithm>
#include <cmath>

namespace haptic::core {

namespace {

using Complex = std::complex<double>;

constexpr double dot(Complex a, Complex b) noexcept {
  return a.real() * b.real() + a.imag() * b.imag();
}
constexpr Complex times_i(Complex a) noexcept {
  return {-a.imag(), a.real()};
}
/// a b and a / b without the standard's care for infinities, which costs a library call each.
constexpr Complex times(Complex a, Complex b) noexcept {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}
Complex turn(double angle) noexcept {
  return {std::cos(angle), std::sin(angle)};
}

/// The unit vector u with u (c + i h) = p, i.e. conj((c + i h)/p): |p|^2 = c^2 + h^2.
constexpr Complex direction(double c, double h, Complex p, double p_squared) noexcept {
  const Complex quotient = times({c, h}, {p.real(), -p.imag()});
  return {quotient.real() / p_squared, -quotient.imag() / p_squared};
}

/// Everything both derivative orders share.
struct Assembly {
  Complex body_d, body_e;  // e^{it} d, e^{it} e
  Complex D, E, w;
  Complex u1, u2, n1, n2;
  double c1{0.0}, c2{0.0};
};

bool assemble(const FingerDimensions& dim, Complex P0, Complex e_a, Complex d, Complex e, double l,
              double t, Assembly& a) noexcept {
  const Complex rotation = turn(t);
  const Complex P{P0.real() + l * e_a.real(), P0.imag() + l * e_a.imag()};
  a.body_d = times(rotation, d);
  a.body_e = times(rotation, e);
  a.D = P + a.body_d;
  a.E = P + a.body_e;
  const double D2 = dot(a.D, a.D);
  a.c1 = std::sqrt(D2 - dim.rod1 * dim.rod1);
  if (!(a.c1 >= FingerLinkage::kSmallestSlider)) return false;  // NaN ends here too
  a.u1 = direction(a.c1, dim.rod1, a.D, D2);
  a.w = a.E - dim.proximal_phalanx * a.u1;
  const double w2 = dot(a.w, a.w);
  a.c2 = std::sqrt(w2 - dim.rod2 * dim.rod2);
  if (!(a.c2 >= FingerLinkage::kSmallestSlider)) return false;
  a.u2 = direction(a.c2, dim.rod2, a.w, w2);
  a.n1 = times_i(a.u1);
  a.n2 = times_i(a.u2);
  return std::isfinite(a.c1) && std::isfinite(a.c2);
}

void joints_of(const Assembly& a, double& q1, double& q2) noexcept {
  q1 = std::atan2(-a.u1.imag(), a.u1.real());
  const Complex relative = times(a.u1, std::conj(a.u2));
  q2 = std::atan2(relative.imag(), relative.real());
}

struct First {
  Complex D_k[2], E_k[2];
  Complex w_k[2];
};

void first_derivatives(const FingerDimensions& dim, Complex e_a, const Assembly& a, First& f,
                       LinkagePose& out) noexcept {
  f.D_k[0] = f.E_k[0] = e_a;
  f.D_k[1] = times_i(a.body_d);
  f.E_k[1] = times_i(a.body_e);
  for (int k = 0; k < 2; ++k) {
    out.q1_k[k] = -dot(a.n1, f.D_k[k]) / a.c1;
    out.c1_k[k] = dot(a.u1, f.D_k[k]) - dim.rod1 * out.q1_k[k];
    f.w_k[k] = f.E_k[k] + dim.proximal_phalanx * out.q1_k[k] * a.n1;
    out.phi_k[k] = -dot(a.n2, f.w_k[k]) / a.c2;
    out.c2_k[k] = dot(a.u2, f.w_k[k]) - dim.rod2 * out.phi_k[k];
  }
}

/// d2 x / ds2 along the direction (l_dot, t_dot), Eq. (11).
Eigen::Vector2d second_along(const FingerDimensions& dim, Complex e_a, const Assembly& a,
                             double l_dot, double t_dot) noexcept {
  const double t_dot2 = t_dot * t_dot;
  const Complex D_1 = l_dot * e_a + t_dot * times_i(a.body_d);
  const Complex E_1 = l_dot * e_a + t_dot * times_i(a.body_e);
  const double q1_1 = -dot(a.n1, D_1) / a.c1;
  const double c1_1 = dot(a.u1, D_1) - dim.rod1 * q1_1;
  const Complex w_1 = E_1 + dim.proximal_phalanx * q1_1 * a.n1;
  const double phi_1 = -dot(a.n2, w_1) / a.c2;
  const double c2_1 = dot(a.u2, w_1) - dim.rod2 * phi_1;
  const double q1_2 =
      (t_dot2 * dot(a.n1, a.body_d) - 2.0 * c1_1 * q1_1 - dim.rod1 * q1_1 * q1_1) / a.c1;
  const Complex w_2 =
      -t_dot2 * a.body_e + dim.proximal_phalanx * (q1_1 * q1_1 * a.u1 + q1_2 * a.n1);
  const double phi_2 = -(dot(a.n2, w_2) + 2.0 * c2_1 * phi_1 + dim.rod2 * phi_1 * phi_1) / a.c2;
  return {q1_2, phi_2 - q1_2};
}

/// Eq. (12). Leaves what D and E are made of in `a`.
bool assemble_closed(const FingerDimensions& dim, Complex P0, Complex e_a, Complex d, Complex e,
                     double q1, double q2, ClosedPose& out, Assembly& a) noexcept {
  a.u1 = std::conj(turn(q1));
  a.u2 = std::conj(turn(q1 + q2));
  a.n1 = times_i(a.u1);
  a.n2 = times_i(a.u2);
  const double k1 = dot(a.n1, e_a), k2 = dot(a.n2, e_a);
  const double r1 = dim.rod1 - dot(a.n1, P0);
  const double r2 = dim.rod2 - dot(a.n2, P0) + dim.proximal_phalanx * dot(a.n2, a.u1);
  const double A1 = dot(a.n1, d), B1 = dot(a.n1, times_i(d));
  const double A2 = dot(a.n2, e), B2 = dot(a.n2, times_i(e));
  const double alpha = k1 * A2 - k2 * A1, beta = k1 * B2 - k2 * B1, g = k1 * r2 - k2 * r1;
  const double radius2 = alpha * alpha + beta * beta;
  const double s2 = radius2 - g * g;
  if (!(s2 >= 0.0) || (k1 == 0.0 && k2 == 0.0)) return false;
  const double s = std::sqrt(s2);
  // (cos t, sin t) scaled by alpha^2 + beta^2 = g^2 + s^2.
  const Complex rotation{(alpha * g + beta * s) / radius2, (beta * g - alpha * s) / radius2};
  out.t = std::atan2(rotation.imag(), rotation.real());
  out.l = std::abs(k1) >= std::abs(k2) ? (r1 - A1 * rotation.real() - B1 * rotation.imag()) / k1
                                       : (r2 - A2 * rotation.real() - B2 * rotation.imag()) / k2;
  const Complex P{P0.real() + out.l * e_a.real(), P0.imag() + out.l * e_a.imag()};
  a.body_d = times(rotation, d);
  a.body_e = times(rotation, e);
  a.D = P + a.body_d;
  a.E = P + a.body_e;
  out.c1 = a.c1 = dot(a.u1, a.D);
  out.c2 = a.c2 = dot(a.u2, a.E) - dim.proximal_phalanx * dot(a.u2, a.u1);
  return std::isfinite(out.l) && std::isfinite(out.t);
}

}  // namespace

FingerLinkage::FingerLinkage(const FingerDimensions& dimensions)
    : dim_(dimensions),
      P0_(dimensions.rail_origin.x, dimensions.rail_origin.y),
      e_a_(turn(dimensions.rail_angle)),
      d_(dimensions.body_d.x, dimensions.body_d.y),
      e_(dimensions.body_e.x, dimensions.body_e.y) {}

bool FingerLinkage::joints(double l, double t, double& q1, double& q2) const noexcept {
  Assembly a;
  if (!assemble(dim_, P0_, e_a_, d_, e_, l, t, a)) return false;
  joints_of(a, q1, q2);
  return true;
}

bool FingerLinkage::pose(double l, double t, LinkagePose& out) const noexcept {
  Assembly a;
  if (!assemble(dim_, P0_, e_a_, d_, e_, l, t, a)) return false;
  out.c1 = a.c1;
  out.c2 = a.c2;
  joints_of(a, out.q1, out.q2);
  First f;
  first_derivatives(dim_, e_a_, a, f, out);
  return true;
}

/// Takes three directions: that of l, that of t, and their sum.
bool FingerLinkage::hessian(double l, double t, double (&H)[2][2][2]) const noexcept {
  Assembly a;
  if (!assemble(dim_, P0_, e_a_, d_, e_, l, t, a)) return false;
  const Eigen::Vector2d ll = second_along(dim_, e_a_, a, 1.0, 0.0);
  const Eigen::Vector2d tt = second_along(dim_, e_a_, a, 0.0, 1.0);
  const Eigen::Vector2d both = second_along(dim_, e_a_, a, 1.0, 1.0);
  for (int i = 0; i < 2; ++i) {
    H[i][0][0] = ll[i];
    H[i][1][1] = tt[i];
    H[i][0][1] = H[i][1][0] = 0.5 * (both[i] - ll[i] - tt[i]);
  }
  return true;
}

bool FingerLinkage::velocity_product(double l, double t, double l_dot, double t_dot,
                                     Eigen::Vector2d& out) const noexcept {
  Assembly a;
  if (!assemble(dim_, P0_, e_a_, d_, e_, l, t, a)) return false;
  out = second_along(dim_, e_a_, a, l_dot, t_dot);
  return true;
}

bool FingerLinkage::closed_inverse(double q1, double q2, ClosedPose& out) const noexcept {
  Assembly a;
  return assemble_closed(dim_, P0_, e_a_, d_, e_, q1, q2, out, a);
}

bool FingerLinkage::closed_motion(const Eigen::Vector2d& x, const Eigen::Vector2d& x_dot,
                                  ClosedPose& out,
                                  FingerExoskeleton::Motion& motion) const noexcept {
  Assembly a;
  if (!assemble_closed(dim_, P0_, e_a_, d_, e_, x[0], x[1], out, a)) return false;
  if (!(a.c1 >= kSmallestSlider && a.c2 >= kSmallestSlider)) return false;
  LinkagePose p;
  First f;
  first_derivatives(dim_, e_a_, a, f, p);
  motion.J << p.J(0, 0), p.J(0, 1), p.J(1, 0), p.J(1, 1);
  const double det = p.det();
  motion.product = second_along(dim_, e_a_, a, (p.J(1, 1) * x_dot[0] - p.J(0, 1) * x_dot[1]) / det,
                                (p.J(0, 0) * x_dot[1] - p.J(1, 0) * x_dot[0]) / det);
  return true;
}

}  // namespace haptic::core
