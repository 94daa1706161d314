#include "haptic/core/contacts/plane_projection.hpp"

namespace haptic::core {

namespace {

/// Times of a replay, and of a step with n contacts, measured: a + b n + c n^2, flat and curved.
constexpr double kReplay_ns = 16000.0;
constexpr double kFlat_ns[] = {25.0, 25.0, 5.0}, kCurved_ns[] = {20.0, 110.0, 15.0};

}  // namespace

void PlaneProjection::set(const PlaneSet& planes, const VecX& x, const VecX* x_used) noexcept {
  begun_ = false;
  gaps_.set(planes, x);
  laws_.set(planes, gaps_.length(), gaps_.left_out());
  for (int i = 0; laws_.any() && i < gaps_.size(); ++i) {
    if (laws_.has(i)) gaps_.stop(i);
  }
  bound_.set(planes, laws_.any());
  solver_.begin();
  anchor_.clear();
  if (x_used != nullptr) {
    gaps_.difference(*x_used, y_);
    anchor_.set(y_);
  }
  gaps_.keep();
}

bool PlaneProjection::begin_at_anchor() noexcept {
  // Where x is not the sample's own, curved gaps are linearised elsewhere, and push otherwise.
  begun_ = anchor_.known() && (gaps_.curved() == 0 || anchor_.explained());
  if (!begun_) return false;
  static_cast<void>(laws_.begin(0.0));
  laws_.end(solver_.l());
  return true;
}

void PlaneProjection::rewind() noexcept {
  laws_.rewind();
  laws_.compare_next();
  solver_.dual().allow(kMostWork / 4);
}

PlaneStatus PlaneProjection::project(const VecX& x_probe, VecX& x, double age, double dt,
                                     int most_steps) noexcept {
  x = x_probe;
  if (gaps_.size() == 0) return PlaneStatus::kFree;
  if (laws_.any() && laws_.begin(begun_ ? dt : 0.0) && gaps_.curved() == 0) solver_.fill();
  begun_ = true;
  gaps_.difference(x_probe, y_);
  const PlaneStatus status = solver_.project(y_, age, most_steps);
  if (laws_.any()) {
    ContactSolver::Vector l;
    const int n = gaps_.size();
    l.head(n) = solver_.l().head(n).cwiseProduct(gaps_.scale().head(n));
    laws_.end(l);
  }
  gaps_.displace(y_, solver_.l(), solver_.held(), x);
  if (x.allFinite()) return status;
  // Numbers at the ends of what may be told, such as a normal of 1e-100: nothing follows from them.
  x = x_probe;
  solver_.dual().hold_none();
  return PlaneStatus::kInfeasible;
}

double PlaneProjection::stored() const noexcept {
  double sum = laws_.any() ? laws_.energy() : 0.0;
  for (int i = 0; solver_.held() != 0 && i < gaps_.size(); ++i) {
    sum += 0.5 * gaps_.gamma()[i] * solver_.l()[i] * solver_.l()[i];
  }
  return sum;
}

double PlaneProjection::coupling() const noexcept {
  if (solver_.held() == 0) return 0.0;
  const ContactSolver::Vector& l = solver_.l();
  VecX displaced = VecX::Zero(gaps_.space().n_x());
  double sum = 0.0;
  for (int i = 0; i < gaps_.size(); ++i) {
    if (l[i] > 0.0) gaps_.push(displaced, l[i], i);
  }
  for (int i = 0; i < gaps_.size(); ++i) sum += 0.5 * l[i] * gaps_.along(i, displaced.data());
  return sum;
}

int PlaneProjection::replayable() const noexcept {
  const double* cost = gaps_.curved() == 0 ? kFlat_ns : kCurved_ns;
  const int n = gaps_.size();
  return 1 + static_cast<int>(kReplay_ns / (cost[0] + n * (cost[1] + n * cost[2])));
}

}  // namespace haptic::core
