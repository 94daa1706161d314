#include "haptic/core/rendering/per_contact.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "haptic/core/contacts/contact_leverage.hpp"
#include "haptic/core/error.hpp"

namespace haptic::core {

namespace {

constexpr double kBandJoint = 0.25 * 0.017453292519943295;  // rad
constexpr double kBandPoint = 0.0005;                       // m
constexpr double kBandOfMetric = 0.05;

constexpr double kSettled = 1e-13;  // of tau_8: rounding
constexpr double kRoom = 1.1;       // for the second order of a small way

}  // namespace

double contact_band(const ProjectionModel& model) noexcept {
  if (!model.metric().is_identity()) return kBandOfMetric;
  const auto& coordinates = model.kinematics().space().coordinates();
  const bool metres = !coordinates.empty() && coordinates.front().unit == Unit::kMetre;
  return metres ? kBandPoint : kBandJoint;
}

bool contacts_by_joint(const ProjectionModel& model) noexcept {
  const auto& coordinates = model.kinematics().space().coordinates();
  return model.n_x() <= kMaxQ &&
         std::all_of(coordinates.begin(), coordinates.end(), [](const Coordinate& c) {
           return c.unit == Unit::kRadian && c.kind != CoordinateKind::kQuaternion;
         });
}

PerContact::PerContact(const ProjectionModel& model)
    : model_(model),
      band_(contact_band(model)),
      small_(band_ * (band_ == kBandJoint ? 0.4 : 0.2)),
      by_joint_(contacts_by_joint(model)),
      solver_(model.n_x(), model.layout(), model.coupling()),
      tau_(VecA::Zero(model.layout().n_a())),
      out_(VecX::Zero(model.n_x())) {
  const int n_q = model.layout().n_q(), rows = model.n_x() + n_q;
  if (rows <= kMaxX) {
    extended_.emplace(rows, model.layout(), model.coupling());
    rows_ = MatXQ::Zero(rows, n_q);
    rhs_ = VecX::Zero(rows);
  } else if (model.prior()) {
    throw SceneError("per_contact: with a prior it must have at most " + std::to_string(kMaxX) +
                     " coordinates and DoFs together, not " + std::to_string(rows));
  }
}

void PerContact::project(const Probe& probe, const VecX& /*x*/, const VecX& dx,
                         const VecA& stiffness, bool proxy_changed, Projection& out) noexcept {
  const MatXQ& J = model_.metric().weighed(probe.J, J_W_);
  const VecX& d = model_.metric().weighed(dx, dx_W_);
  const LeastSquares& solver = solve(probe, J, d, stiffness, proxy_changed, out);
  out.q_star = probe.q + solver.dq();
  // Damping leaves the motors less force, and the finger feels what they give as before.
  const bool plain = !model_.prior() && solver_.status() == ProjectionStatus::kExact;
  const LeastSquares& levers = plain ? solver_ : solver;
  const DofLayout& layout = model_.layout();
  const int n_a = layout.n_a();
  for (int i = 0; i < n_a; ++i) tau_[i] = stiffness[i] * solver.dq()[layout.actuated(i)];

  pushed_ = 0;
  bool pushed_in = false;
  double share = 1.0;  // with one actuator the optimum is a share of tau_8
  for_each_contact(model_, probe.contacts, dx, by_joint_, out_,
                   [&](VecX& direction, double depth, int contact) {
                     if (pushed_ == kMost) return;
                     model_.metric().weigh(direction);
                     Push& push = pushes_[static_cast<std::size_t>(pushed_++)];
                     push.out = levers.also(J, direction);
                     push.depth = depth;
                     push.cosine = leverage(levers, push.out);
                     push.slack = slack_at(depth, band_, push.cosine);
                     push.contact = contact;
                     if (push.out.dot(tau_) < 0.0) {
                       pushed_in = true;
                       share = std::min(share, push.slack);
                     }
                   });
  if (n_a == 1) {
    if (!pushed_in) return;
    out.q_wish = out.q_star;
    tau_ *= share;
    out.q_star[layout.actuated(0)] =
        probe.q[layout.actuated(0)] + share * solver.dq()[layout.actuated(0)];
    out.contradicted = share < 1.0;
    return;
  }
  const VecA within = most(probe.contacts, stiffness);
  if (!pushed_in && (tau_.array().abs() <= within.array()).all()) return;
  out.q_wish = out.q_star;
  out.contradicted = hold_back(levers, within);
  for (int i = 0; i < n_a; ++i) {
    const int k = layout.actuated(i);
    if (stiffness[i] > 0.0) out.q_star[k] = probe.q[k] + tau_[i] / stiffness[i];
  }
}

VecA PerContact::most(const ContactView& view, const VecA& stiffness) const noexcept {
  const Eigen::Index n_a = stiffness.size();
  VecA within = VecA::Constant(n_a, std::numeric_limits<double>::infinity());
  if (view.force_limit != nullptr) within = view.force_limit->segment(view.first_a, n_a);
  for (Eigen::Index i = 0; i < n_a; ++i) {
    if (!(stiffness[i] > 0.0)) within[i] = 0.0;  // no spring that could give it
  }
  return within;
}

/// The dual by active set: the conditions that hold tau_ back, one more as long as one is broken,
/// one less if its multiplier would become negative. 0 meets every condition, so there is an
/// answer, and it is no longer than tau_8 in the norm of what the finger feels, which bounds the
/// push on every contact: a slack of 1 is no condition.
bool PerContact::hold_back(const LeastSquares& solver, const VecA& limit) noexcept {
  constexpr int kLargest = kMaxQ + 1;  // more conditions than that cannot be independent
  using Active = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kLargest, 1>;
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kLargest, kLargest>;
  const int n_a = static_cast<int>(tau_.size()), conditions = pushed_ + 2 * n_a;
  const VecA tau_8 = tau_;
  const double felt = solver.felt(tau_8);
  VecA along(n_a);
  double least = 0.0;  // along . tau_a >= least
  const auto condition = [&](int i) {
    if (i < pushed_) {
      const Push& push = pushes_[static_cast<std::size_t>(i)];
      along = push.out;
      least = -push.slack * std::sqrt(along.dot(solver.actuated_square(along))) * felt;
      return;
    }
    const int k = (i - pushed_) / 2;
    along.setZero();
    along[k] = (i - pushed_) % 2 == 0 ? 1.0 : -1.0;
    least = -limit[k];
  };
  int index[kLargest]{}, n = 0;
  bool held = false;
  Eigen::Matrix<double, kMaxQ, kLargest> C, D;  // the active conditions and H^-1 times them
  Active r(0), l(0);
  for (int pass = 0; pass < 4 * conditions; ++pass) {
    int worst = -1;
    double deepest = kSettled * felt;
    for (int i = 0; i < conditions; ++i) {
      if (std::find(index, index + n, i) != index + n) continue;
      condition(i);
      const double length2 = along.dot(solver.actuated_square(along));
      const double broken = (least - along.dot(tau_)) / std::sqrt(length2);
      if (!(broken > deepest)) continue;
      deepest = broken;
      worst = i;
    }
    if (worst < 0 || n == kLargest) break;
    condition(worst);
    C.col(n).head(n_a) = along;
    D.col(n).head(n_a) = solver.actuated_square(along);
    r.conservativeResize(n + 1);
    l.conservativeResize(n + 1);
    r[n] = least - along.dot(tau_8);
    l[n] = 0.0;
    index[n++] = worst;
    held = held || worst < pushed_;
    while (n > 0) {
      Square G = C.topLeftCorner(n_a, n).transpose().lazyProduct(D.topLeftCorner(n_a, n));
      G.diagonal() *= 1.0 + kSettled;
      const Active s = G.llt().solve(r);
      double step = 1.0;
      for (int k = 0; k < n; ++k) {
        if (s[k] < 0.0) step = std::min(step, l[k] / (l[k] - s[k]));
      }
      l += step * (s - l);
      if (step >= 1.0) break;
      int kept = 0;
      for (int k = 0; k < n; ++k) {
        if (s[k] < 0.0 && l[k] <= kSettled * s.cwiseAbs().maxCoeff()) continue;
        C.col(kept) = C.col(k);
        D.col(kept) = D.col(k);
        r[kept] = r[k];
        l[kept] = l[k];
        index[kept++] = index[k];
      }
      n = kept;
      r.conservativeResize(n);
      l.conservativeResize(n);
    }
    tau_ = tau_8;
    for (int k = 0; k < n; ++k) tau_ += l[k] * D.col(k).head(n_a);
  }
  if (!tau_.allFinite()) tau_.setZero();
  return held;
}

const LeastSquares& PerContact::solve(const Probe& probe, const MatXQ& J, const VecX& d,
                                      const VecA& stiffness, bool proxy_changed,
                                      Projection& out) noexcept {
  if (model_.prior()) {
    const VecQ rest = target_.at(probe.q, model_.layout(), proxy_changed) - probe.q;
    const LeastSquares& solver = solve_with(J, d, model_.prior_weight(stiffness), rest, stiffness);
    out.status = solver.status();
    out.condition = solver.condition();
    out.residual = (d - J.lazyProduct(solver.dq())).norm();
    return solver;
  }
  solver_.solve(J, d, stiffness);
  out.status = solver_.status();
  out.condition = solver_.condition();
  out.residual = solver_.residual();
  if (!extended_) return solver_;
  VecA tau = stiffness;
  for (int i = 0; i < tau.size(); ++i) tau[i] *= solver_.dq()[model_.layout().actuated(i)];
  const double near = 1.0 / out.condition, from = damped_from(probe.contacts, stiffness, tau);
  if (!(near < from)) return solver_;
  const double share = near / from;  // 1: damping begins, 0: singular
  out.damping = 1.0 - share * share;
  const LeastSquares& solver =
      solve_with(J, d, damping_weight(J, stiffness, 0.5 * (from * from - near * near)),
                 VecQ::Zero(model_.layout().n_q()), stiffness);
  out.residual = (d - J.lazyProduct(solver.dq())).norm();
  return solver;
}

double PerContact::damped_from(const ContactView& view, const VecA& stiffness,
                               const VecA& tau) const noexcept {
  const double near = 1.0 / solver_.condition();
  if (!(near < kNear)) return 0.0;
  double square = kDamped * kDamped;
  const Eigen::Index n_a = tau.size();
  for (Eigen::Index i = 0; i < n_a && view.force_limit != nullptr; ++i) {
    const double limit = (*view.force_limit)[view.first_a + i];
    if (!(limit > 0.0)) continue;
    square = std::max(square, near * kRamp * std::abs(tau[i]) / limit);
    if (solver_.status() != ProjectionStatus::kExact) continue;
    const double steep = kRoom * stiffness[i] * solver_.felt(VecA::Unit(n_a, i)) * small_ / limit;
    square = std::max(square, near * near * steep / kGentle);
  }
  return std::min(kNear, std::sqrt(square));
}

const LeastSquares& PerContact::solve_with(const MatXQ& J, const VecX& d, const VecQ& weight,
                                           const VecQ& target, const VecA& stiffness) noexcept {
  const Eigen::Index n_x = J.rows(), n_q = J.cols();
  rows_.topRows(n_x) = J;
  rows_.bottomRows(n_q) = weight.asDiagonal();
  rhs_.head(n_x) = d;
  rhs_.tail(n_q) = weight.cwiseProduct(target);
  extended_->solve(rows_, rhs_, stiffness);
  return *extended_;
}

/// The metric's actuated block is Z_q (core/METHOD.md#rank-and-prior), scaled to the columns' size.
VecQ PerContact::damping_weight(const MatXQ& J, const VecA& stiffness,
                                double square) const noexcept {
  const DofLayout& layout = model_.layout();
  VecQ weight = std::sqrt(square) * J.colwise().norm().transpose();
  double size = 0.0;
  int driven = 0;
  for (int i = 0; i < layout.n_a(); ++i) {
    if (!(stiffness[i] > 0.0)) continue;
    size += weight[layout.actuated(i)] * weight[layout.actuated(i)] / stiffness[i];
    ++driven;
  }
  for (int i = 0; i < layout.n_a(); ++i) {
    if (stiffness[i] > 0.0) weight[layout.actuated(i)] = std::sqrt(size / driven * stiffness[i]);
  }
  return weight;
}

}  // namespace haptic::core
