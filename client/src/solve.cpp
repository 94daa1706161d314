#include "haptic/client/solve.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace haptic::client {

namespace {

using Vector = std::vector<double>;
using Matrix = std::vector<Vector>;

constexpr int kHalvings = 30;
/// Least compliance of a contact, relative to what the coupling gives way: rigid contacts that say
/// the same, or that contradict each other, then have an answer too.
constexpr double kRigid = 1e-12;
constexpr double kNoise = 1e-14;  ///< of the energy: what rounding may raise it by

double dot(const Vector& a, const Vector& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

void add(Vector& to, double factor, const Vector& b) {
  for (std::size_t i = 0; i < b.size(); ++i) to[i] += factor * b[i];
}

/// Cholesky's factor of a symmetric A, in its lower triangle; false: A is not positive definite.
bool factorise(Matrix& A) {
  for (std::size_t i = 0; i < A.size(); ++i) {
    const double least = 1e-14 * A[i][i];
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = A[i][j];
      for (std::size_t k = 0; k < j; ++k) sum -= A[i][k] * A[j][k];
      if (i == j && !(sum > least)) return false;
      A[i][j] = i == j ? std::sqrt(sum) : sum / A[j][j];
    }
  }
  return true;
}

/// A^-1 b, by the factor L of A.
Vector solved(const Matrix& L, Vector b) {
  for (std::size_t i = 0; i < b.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) b[i] -= L[i][k] * b[k];
    b[i] /= L[i][i];
  }
  for (std::size_t i = b.size(); i-- > 0;) {
    for (std::size_t k = i + 1; k < b.size(); ++k) b[i] -= L[k][i] * b[k];
    b[i] /= L[i][i];
  }
  return b;
}

/// The m >= 0 that minimises m^T A m / 2 + b^T m, A positive definite (Lawson and Hanson, Solving
/// Least Squares Problems, ch. 23).
Vector pushes(const Matrix& A, const Vector& b) {
  Vector m(b.size(), 0.0);
  std::vector<std::size_t> pushing;
  double least = 0.0;
  for (const double gap : b) least = std::max(least, 1e-14 * std::abs(gap));
  for (std::size_t turn = 0; turn < 3 * b.size(); ++turn) {
    std::size_t deepest = b.size();
    double depth = least;
    for (std::size_t i = 0; i < b.size(); ++i) {
      const double in = -b[i] - dot(A[i], m);
      if (in <= depth || std::count(pushing.begin(), pushing.end(), i) > 0) continue;
      deepest = i;
      depth = in;
    }
    if (deepest == b.size()) break;
    pushing.push_back(deepest);
    for (bool done = false; !done;) {
      Matrix part(pushing.size(), Vector(pushing.size()));
      Vector wanted(pushing.size());
      for (std::size_t i = 0; i < pushing.size(); ++i) {
        wanted[i] = -b[pushing[i]];
        for (std::size_t j = 0; j <= i; ++j) part[i][j] = A[pushing[i]][pushing[j]];
      }
      if (!factorise(part)) return m;
      wanted = solved(part, std::move(wanted));
      double share = 1.0;  // of the way to what is wanted, until one of them lets go
      std::size_t letting_go = b.size();
      for (std::size_t i = 0; i < pushing.size(); ++i) {
        const double now = m[pushing[i]];
        if (wanted[i] > 0.0 || now > share * (now - wanted[i])) continue;
        share = now / (now - wanted[i]);
        letting_go = pushing[i];
      }
      for (std::size_t i = 0; i < pushing.size(); ++i) {
        m[pushing[i]] += share * (wanted[i] - m[pushing[i]]);
      }
      done = letting_go == b.size();
      if (!done) m[letting_go] = 0.0;
      std::erase(pushing, letting_go);
    }
  }
  return m;
}

[[noreturn]] void refuse(const std::string& name, double value, const char* allowed) {
  throw std::invalid_argument(name + ": " + std::to_string(value) + ", must be " + allowed);
}

void check(const char* name, const Vector& values, std::size_t size, bool positive = false) {
  if (values.size() != size) {
    throw std::invalid_argument(std::string(name) + ": has " + std::to_string(values.size()) +
                                " values, must have " + std::to_string(size));
  }
  for (std::size_t i = 0; i < size; ++i) {
    const std::string part = std::string(name) + "[" + std::to_string(i) + "]";
    if (!std::isfinite(values[i])) refuse(part, values[i], "finite");
    if (positive && !(values[i] > 0.0)) refuse(part, values[i], "> 0");
  }
}

/// The contacts at one x.
struct Place {
  Vector x{}, gaps{};
  Matrix gradients{};
  std::vector<Plane> planes{};
};

class Problem {
 public:
  Problem(const ContactsAt& contacts, const Vector& probe, double coupling, const Vector& weights)
      : contacts_(contacts), probe_(probe), coupling_(coupling), weights_(weights) {}

  [[nodiscard]] Place at(Vector x) const {
    Place place{.x = std::move(x)};
    for (const Contact& contact : contacts_(place.x)) {
      const std::string name = "contacts[" + std::to_string(place.gaps.size()) + "].";
      if (!std::isfinite(contact.gap)) refuse(name + "gap", contact.gap, "finite");
      if (!(contact.stiffness > 0.0)) refuse(name + "stiffness", contact.stiffness, "> 0");
      Plane plane = contact_at(place.x, contact, coupling_);
      check((name + "normal . point.jacobian").c_str(), plane.normal, place.x.size());
      check((name + "curvature").c_str(), plane.curvature, plane.curvature.size());
      Vector gradient = plane.normal;
      for (double& slope : gradient) slope = -slope;
      place.gaps.push_back(contact.gap);
      place.gradients.push_back(std::move(gradient));
      place.planes.push_back(std::move(plane));
    }
    return place;
  }

  /// Energy of coupling and contacts, over the coupling's stiffness; a rigid contact costs `rigid`
  /// times its depth.
  [[nodiscard]] double energy(const Place& at, double rigid) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < at.x.size(); ++i) {
      sum += 0.5 * weights_[i] * (at.x[i] - probe_[i]) * (at.x[i] - probe_[i]);
    }
    for (std::size_t i = 0; i < at.gaps.size(); ++i) {
      const double depth = std::max(-at.gaps[i], 0.0), compliance = at.planes[i].compliance;
      sum += compliance > 0.0 ? 0.5 * depth * depth / compliance : rigid * depth;
    }
    return sum;
  }

  struct Step {
    Vector way{}, pushes{};
  };
  /// To the minimum of a model of the energy around a place: first with flat gaps, then with the
  /// curvature that their pushes give the energy, unless that model has no minimum.
  [[nodiscard]] Step step(const Place& at) const {
    Matrix H(at.x.size(), Vector(at.x.size(), 0.0));
    for (std::size_t i = 0; i < H.size(); ++i) H[i][i] = weights_[i];
    Matrix L = H;
    static_cast<void>(factorise(L));
    Step flat = step(at, L);
    for (std::size_t p = 0; p < at.planes.size(); ++p) {
      const Plane& plane = at.planes[p];
      for (std::size_t k = 0, i = plane.first_coordinate; k < plane.curvature.size(); ++i) {
        for (std::size_t j = plane.first_coordinate; j <= i; ++j) {
          H[i][j] -= flat.pushes[p] * plane.curvature[k++];
        }
      }
    }
    return factorise(H) ? step(at, H) : flat;
  }

  /// Rigid contacts that x still violates.
  [[nodiscard]] static bool inside(const Place& at, double tolerance) {
    for (std::size_t i = 0; i < at.gaps.size(); ++i) {
      const double slope = std::sqrt(dot(at.gradients[i], at.gradients[i]));
      if (at.planes[i].compliance == 0.0 && at.gaps[i] < -10.0 * tolerance * slope) return true;
    }
    return false;
  }

 private:
  [[nodiscard]] Step step(const Place& at, const Matrix& L) const {
    Step step;
    for (std::size_t i = 0; i < at.x.size(); ++i) {
      step.way.push_back(weights_[i] * (probe_[i] - at.x[i]));
    }
    step.way = solved(L, std::move(step.way));
    Matrix moves, A;
    Vector gaps;
    for (std::size_t i = 0; i < at.gaps.size(); ++i) {
      moves.push_back(solved(L, at.gradients[i]));
      gaps.push_back(at.gaps[i] + dot(at.gradients[i], step.way));
    }
    for (std::size_t i = 0; i < at.gaps.size(); ++i) {
      A.emplace_back();
      for (const Vector& move : moves) A[i].push_back(dot(at.gradients[i], move));
      const double yields = std::max(at.planes[i].compliance, kRigid * A[i][i]);
      A[i][i] = A[i][i] + yields > 0.0 ? A[i][i] + yields : 1.0;
    }
    step.pushes = pushes(A, gaps);
    for (std::size_t i = 0; i < moves.size(); ++i) add(step.way, step.pushes[i], moves[i]);
    return step;
  }

  const ContactsAt& contacts_;
  const Vector& probe_;
  double coupling_;
  const Vector& weights_;
};

}  // namespace

Solution solve(const ContactsAt& contacts, const Vector& x_probe, double coupling,
               const SolveOptions& options) {
  const Vector& start = options.start.empty() ? x_probe : options.start;
  const Vector weights = options.weights.empty() ? Vector(x_probe.size(), 1.0) : options.weights;
  check("x_probe", x_probe, x_probe.size());
  check("options.start", start, x_probe.size());
  check("options.weights", weights, x_probe.size(), true);
  if (!std::isfinite(coupling) || !(coupling > 0.0)) refuse("coupling", coupling, "finite, > 0");
  const Problem problem(contacts, x_probe, coupling, weights);
  Place here = problem.at(start);
  bool still = false;
  int iteration = 0;
  while (!still && iteration < options.iterations) {
    ++iteration;
    const Problem::Step step = problem.step(here);
    double largest = 0.0, length = 0.0;
    for (const double push : step.pushes) largest = std::max(largest, push);
    for (const double part : step.way) length = std::max(length, std::abs(part));
    const double rigid = 1.5 * largest;  // > the pushes: no violation pays
    const double energy = problem.energy(here, rigid);
    double share = 1.0;
    for (int halving = 0;; ++halving, share *= 0.5) {
      Vector x = here.x;
      add(x, share, step.way);
      Place there = problem.at(std::move(x));
      if (problem.energy(there, rigid) <= energy + kNoise * std::abs(energy)) {
        here = std::move(there);
        break;
      }
      if (halving == kHalvings) return {here.x, here.planes, false, iteration};
    }
    still = share * length <= options.tolerance;
  }
  const bool converged = still && !Problem::inside(here, options.tolerance);
  return {std::move(here.x), std::move(here.planes), converged, iteration};
}

}  // namespace haptic::client
