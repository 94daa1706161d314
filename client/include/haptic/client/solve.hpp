#pragma once
/// The proxy of a simulation that has contacts and no solver of its own.
///
///   const auto pads = [&](const std::vector<double>& x) { return contacts_near(x, horizon); };
///   const Solution found = solve(pads, state.x_probe, 0.02, {.start = last});
///   session->publish(found.proxy());
///   last = found.x;

#include <functional>
#include <vector>

#include "haptic/client/contact.hpp"
#include "haptic/client/types.hpp"

namespace haptic::client {

/// Your objects: gives the contacts of the tool at x, touched or near. solve() calls it 5 to 20
/// times as a rule. From one x to the next a contact may come or go if its gap is > 0.
using ContactsAt = std::function<std::vector<Contact>(const std::vector<double>& x)>;

struct SolveOptions {
  /// Where to begin: the last proxy, so that the tool stays on the side of each object that it came
  /// from. Empty: the probe. The nearest minimum is found, not the least one: let a probe that
  /// jumped come in pieces of a few mm or 0.05 rad.
  std::vector<double> start{};
  /// Diagonal of W, per coordinate, > 0; empty: all 1.
  std::vector<double> weights{};
  int iterations{50};       ///< of Newton, at most; each calls ContactsAt 1 to 31 times
  double tolerance{1e-10};  ///< of each coordinate, in its unit
};

struct Solution {
  std::vector<double> x{};      ///< the proxy
  std::vector<Plane> planes{};  ///< contact_at() of all contacts at x
  /// false: `x` is the best that was found. Either `iterations` did not suffice, or the rigid
  /// contacts contradict each other. A simulation may publish it: the next step goes on from there.
  bool converged{false};
  int iterations{0};

  /// For publish().
  [[nodiscard]] Proxy proxy() const {
    return planes.empty() ? Proxy::free() : Proxy::behind(planes, x);
  }
};

/// The x that minimises, near options.start,
///   coupling / 2 (x - x_probe)^T W (x - x_probe) + sum_i stiffness_i / 2 min(gap_i(x), 0)^2,
/// with gap_i >= 0 if the stiffness is infinite. `coupling`: N/m if x is in m, N m/rad if in
/// rad, > 0. Objects stand still meanwhile; their motion is told by the planes. The difference x -
/// x_probe is one of plain numbers: let an angle of x_probe be the one nearest to the start, and a
/// quaternion have the sign that is nearer. The length of a quaternion in x is not kept at 1.
///
/// The method is sequential quadratic programming (Nocedal and Wright, Numerical Optimization, 18.1
/// and 18.4): Newton's method with the contacts' curvature, each step cut until energy and
/// violations fall. Throws std::invalid_argument if a number is not finite or not allowed,
/// std::out_of_range as contact_at() does; the message names it.
[[nodiscard]] Solution solve(const ContactsAt& contacts, const std::vector<double>& x_probe,
                             double coupling, const SolveOptions& options = {});

}  // namespace haptic::client
