#include "haptic/client/deadband.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "difference.hpp"

namespace haptic::client {

namespace {

constexpr std::size_t kMostLaws = 1024;  ///< half a second at the highest rate
constexpr double kMostOfFresh = 0.9;     ///< of fresh_end; the rest is the network's jitter
constexpr double kRigid = 1e-6;          ///< compliance of a rigid plane by |gradient|^2
constexpr double kSoftness = 0.1;        ///< of a compliance; less of a change is hardly felt
constexpr double kEcho = 1e-6;           ///< held as near to its probe as this it is free there
constexpr int kSteps = 20;               ///< of Newton, at most
constexpr double kExact = 1e-3;          ///< of the width

double seconds(std::chrono::nanoseconds span) {
  return std::chrono::duration<double>(span).count();
}

double length(const std::vector<double>& v) {
  double sum = 0.0;
  for (const double part : v) sum += part * part;
  return std::sqrt(sum);
}

/// The gap at x = x_0 + z, t seconds after the sample, and its gradient.
double gap_at(const Plane& plane, const std::vector<double>& x_0, const std::vector<double>& z,
              double t, std::vector<double>& gradient) {
  double gap = plane.offset + plane.velocity * t;
  gradient.resize(z.size());
  for (std::size_t i = 0; i < z.size(); ++i) {
    gap -= plane.normal[i] * (x_0[i] + z[i]);
    gradient[i] = -plane.normal[i];
  }
  std::size_t row = 0;
  for (std::size_t k = 0; k < plane.curvature.size(); ++row) {
    for (std::size_t column = 0; column <= row; ++column, ++k) {
      const std::size_t i = plane.first_coordinate + row, j = plane.first_coordinate + column;
      const double h = plane.curvature[k];
      gap += (i == j ? 0.5 : 1.0) * h * z[i] * z[j];
      gradient[i] += h * z[j];
      if (i != j) gradient[j] += h * z[i];
    }
  }
  return gap;
}

/// Solves A b' = b in place; A: symmetric, positive definite, row by row.
void solve_symmetric(std::vector<double>& A, std::vector<double>& b) {
  const std::size_t n = b.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t r = i + 1; r < n; ++r) {
      const double share = A[r * n + i] / A[i * n + i];
      if (share == 0.0) continue;
      for (std::size_t c = i; c < n; ++c) A[r * n + c] -= share * A[i * n + c];
      b[r] -= share * b[i];
    }
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t c = i + 1; c < n; ++c) b[i] -= A[i * n + c] * b[c];
    b[i] /= A[i * n + i];
  }
}

/// Whether the server can use the plane so; it refuses others, and they are always news.
bool fits(const Plane& plane, std::size_t n_x) {
  std::size_t n = 0;
  while (n * (n + 1) / 2 < plane.curvature.size()) ++n;
  return plane.normal.size() == n_x && n * (n + 1) / 2 == plane.curvature.size() &&
         plane.first_coordinate + n <= n_x && plane.mass == 0.0;
}

}  // namespace

Deadband::Deadband(std::vector<VirtualCoordinate> coordinates, double width, double rate_hz)
    : coordinates_(std::move(coordinates)), width_(width), period_(1.0 / rate_hz) {}

void Deadband::begin(std::chrono::nanoseconds fresh_end) {
  fresh_end_ = seconds(fresh_end);
  laws_.clear();
}

void Deadband::used(std::uint64_t seq) {
  used_ = std::max(used_, seq);
  while (!laws_.empty() && laws_.front().seq < used_) laws_.pop_front();
}

Deadband::Law Deadband::law_of(std::uint64_t seq, const Proxy& proxy,
                               const std::vector<double>& x_probe, TimePoint now) const {
  const std::size_t n_x = coordinates_.size();
  Law law{seq, now, proxy, {}, {}};
  if (proxy.mode == Mode::kHeld && proxy.position.size() == n_x && x_probe.size() == n_x) {
    law.probe = x_probe;
  }
  const auto fitting = [&](const Plane& plane) { return fits(plane, n_x); };
  if (proxy.mode != Mode::kPlanes || proxy.position.size() != n_x || x_probe.size() != n_x ||
      !std::all_of(proxy.planes.begin(), proxy.planes.end(), fitting)) {
    return law;
  }
  law.probe = away(x_probe, proxy.position);
  law.anchor.assign(n_x, 0.0);
  const auto named = [](const Plane& plane) { return plane.id != 0; };
  if (std::any_of(proxy.planes.begin(), proxy.planes.end(), named)) {
    law.anchor = solve(proxy, law.probe, 0.0);
    for (double& part : law.anchor) part = -part;
    if (!shifts_one_gap(proxy, law.anchor)) {
      law.probe.clear();
      return law;
    }
  }
  for (std::size_t i = 0; i < n_x; ++i) law.probe[i] += proxy.position[i];
  return law;
}

/// Whether the server's shift of the gaps is this way of the proxy: within the width it lies along
/// the gradient of the only plane that is touched.
bool Deadband::shifts_one_gap(const Proxy& proxy, std::vector<double> anchor) const {
  const std::vector<double> none(anchor.size(), 0.0);
  std::vector<double> g;
  const Plane* touched = nullptr;
  for (const Plane& plane : proxy.planes) {
    if (gap_at(plane, proxy.position, none, 0.0, g) > width_ * length(g)) continue;
    if (touched != nullptr) return near(anchor, none);
    touched = &plane;
  }
  if (touched == nullptr) return near(anchor, none);
  static_cast<void>(gap_at(*touched, proxy.position, none, 0.0, g));
  double along = 0.0;
  for (std::size_t i = 0; i < g.size(); ++i) along += anchor[i] * g[i];
  for (std::size_t i = 0; i < g.size(); ++i) anchor[i] -= along * g[i] / (length(g) * length(g));
  return near(anchor, none);
}

bool Deadband::is_news(std::uint64_t seq, const Proxy& proxy, const std::vector<double>& x_probe,
                       TimePoint now) {
  if (!(width_ > 0.0)) return true;
  Law law = law_of(seq, proxy, x_probe, now);
  const bool known = !laws_.empty() && laws_.front().seq == used_ && stays_fresh(now);
  if (known &&
      std::all_of(laws_.begin(), laws_.end(), [&](const Law& old) { return same(old, law); })) {
    return false;
  }
  if (laws_.size() == kMostLaws) laws_.pop_front();
  laws_.push_back(std::move(law));
  return true;
}

/// Whether the next sample comes before the last one that was sent is too old.
bool Deadband::stays_fresh(TimePoint now) const {
  const Law& last = laws_.back();
  double fresh = fresh_end_;
  if (last.proxy.valid_for.count() > 0) fresh = std::min(fresh, seconds(last.proxy.valid_for));
  return seconds(now - last.at) + period_ <= kMostOfFresh * fresh;
}

/// to (-) from.
std::vector<double> Deadband::away(const std::vector<double>& to,
                                   const std::vector<double>& from) const {
  std::vector<double> d(from.size());
  for (std::size_t i = 0; i < d.size(); ++i) d[i] = difference(coordinates_, to, from, i);
  return d;
}

/// Per coordinate of a held proxy: it goes on with the probe.
std::vector<bool> Deadband::free(const Law& law) const {
  std::vector<bool> free;
  for (const double d : away(law.proxy.position, law.probe)) free.push_back(std::abs(d) <= kEcho);
  return free;
}

bool Deadband::near(const std::vector<double>& a, const std::vector<double>& b) const {
  const auto d = away(a, b);
  return std::all_of(d.begin(), d.end(), [&](double part) { return std::abs(part) <= width_; });
}

/// The proxy of the planes, less the sample's position; `probe` is less it too. By Newton's steps
/// on 1/2 |x - probe|^2 + 1/2 sum min(0, gap)^2 / compliance.
std::vector<double> Deadband::solve(const Proxy& proxy, const std::vector<double>& probe,
                                    double t) const {
  const std::size_t n = probe.size();
  std::vector<double> z = probe, A, b(n), g;
  for (int step = 0; step < kSteps; ++step) {
    A.assign(n * n, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
      A[i * n + i] = 1.0;
      b[i] = probe[i] - z[i];
    }
    for (const Plane& plane : proxy.planes) {
      const double gap = gap_at(plane, proxy.position, z, t, g);
      if (!(gap < 0.0)) continue;
      const double square = length(g) * length(g);
      const double compliance = std::max(plane.compliance, kRigid * square);
      if (!(compliance > 0.0)) continue;
      for (std::size_t i = 0; i < n; ++i) {
        if (g[i] == 0.0) continue;  // of another finger
        b[i] -= gap * g[i] / compliance;
        for (std::size_t j = 0; j < n; ++j) A[i * n + j] += g[i] * g[j] / compliance;
      }
    }
    solve_symmetric(A, b);
    for (std::size_t i = 0; i < n; ++i) z[i] += b[i];
    const auto small = [&](double part) { return std::abs(part) <= kExact * width_; };
    if (std::all_of(b.begin(), b.end(), small)) break;
  }
  return z;
}

std::vector<double> Deadband::predict(const Law& law, const std::vector<double>& probe,
                                      double t) const {
  std::vector<double> x = solve(law.proxy, away(probe, law.proxy.position), t);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += law.proxy.position[i] + law.anchor[i];
  return x;
}

bool Deadband::same_surface(const Plane& told, const Plane& now, const Law& old, const Law& law,
                            double ahead) const {
  if (told.id != now.id || told.curvature.size() != now.curvature.size() ||
      told.uncertainty.has_value() != now.uncertainty.has_value() ||
      now.uncertainty.value_or(0.0) > told.uncertainty.value_or(0.0)) {
    return false;
  }
  const double age = seconds(law.at - old.at);
  const std::vector<double>&x_0 = old.proxy.position, &x = law.proxy.position;
  std::vector<double> g;
  const std::vector<double> z = away(x, x_0), none(x.size(), 0.0);
  for (const double t : {0.0, ahead}) {
    const double off = gap_at(told, x_0, z, age + t, g) - gap_at(now, x, none, t, g);
    if (!(std::abs(off) <= width_ * length(now.normal))) return false;
  }
  return std::abs(told.compliance - now.compliance) <= kSoftness * now.compliance;
}

bool Deadband::same(const Law& old, const Law& law) const {
  const Proxy &told = old.proxy, &now = law.proxy;
  if (told.mode != now.mode) return false;
  if (now.mode == Mode::kFree) return true;
  const Law& used = laws_.front();
  if (old.probe.empty() || law.probe.empty() || used.probe.empty()) return false;
  if (now.mode == Mode::kHeld) return near(told.position, now.position) && free(old) == free(law);
  if (told.planes.size() != now.planes.size()) return false;
  const double ahead = seconds(law.at - used.at);
  for (std::size_t i = 0; i < now.planes.size(); ++i) {
    if (!same_surface(told.planes[i], now.planes[i], old, law, ahead)) return false;
  }
  const double age = seconds(law.at - old.at);
  std::vector<double> further = away(law.probe, used.probe);
  for (std::size_t i = 0; i < further.size(); ++i) further[i] += law.probe[i];
  return near(predict(old, law.probe, age), predict(law, law.probe, 0.0)) &&
         near(predict(old, further, age + ahead), predict(law, further, ahead));
}

}  // namespace haptic::client
