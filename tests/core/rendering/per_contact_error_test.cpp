// Eq. (39) by the rule per contact (core/METHOD.md#error-bound), by brute force: the rule at the
// proxy and the contacts in use, and at any to which these may be off.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "haptic/core/model/hand_exoskeleton.hpp"
#include "haptic/core/model/linear.hpp"
#include "haptic/core/rendering/block_renderer.hpp"
#include "haptic/core/rendering/force_error.hpp"
#include "tests/support/allocation_guard.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/dense_oracle.hpp"

namespace haptic::core::per_contact_error_test {
namespace {

using Random = std::mt19937_64;

double drawn(Random& random, double lowest, double highest) {
  return std::uniform_real_distribution<double>(lowest, highest)(random);
}

VecX direction(Random& random, Eigen::Index n) {
  std::normal_distribution<double> normal;
  VecX v = VecX::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) v[i] = normal(random);
  return v.normalized();
}

double middle(std::vector<double> values) {
  const auto half = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), half, values.end());
  return *half;
}

/// Well-conditioned, of angles.
std::unique_ptr<Kinematics> map_of_angles(Random& random, int n_x, int n_q, int n_a) {
  LinearMap map;
  for (int i = 0; i < n_q; ++i) {
    map.dofs.push_back({"q" + std::to_string(i), Unit::kMetre, i < n_a, -1e6, 1e6});
  }
  for (int i = 0; i < n_x; ++i) {
    map.coordinates.push_back({"x" + std::to_string(i), Unit::kRadian, CoordinateKind::kLinear});
  }
  map.A.resize(n_x, n_q);
  do {
    for (int i = 0; i < n_q; ++i) map.A.col(i) = direction(random, n_x);
  } while (oracle::condition(map.A) > 30.0);
  return make_linear(map);
}

struct Tally {
  std::vector<double> ratios{};  ///< of the bound to the error
  int trials{0}, known{0}, held_back{0}, held_back_known{0};
};

/// At a pose: x up to 3 degrees off the probe, up to four contacts about their band.
void judge(const Kinematics& map, const VecQ& q, Random& random, Tally& tally) {
  const ProjectionModel model(map);
  BlockRenderer renderer(RendererKind::kPerContact, model);
  ForceError force_error(model);
  const double band = contact_band(model);
  const std::vector<MapBlock> blocks = model.blocks();
  const int n_a = map.layout().n_a(), n_x = map.space().n_x();
  VecX x_probe;
  MatXQ J;
  ASSERT_EQ(map.evaluate(q, x_probe, J), MapStatus::kOk);
  VecA stiffness(n_a);
  for (int a = 0; a < n_a; ++a) stiffness[a] = drawn(random, 300.0, 3000.0);

  const int count = 1 + static_cast<int>(random() % 4);
  Contacts used;
  used.into = MatXQ::Zero(n_x, count);
  used.depth.resize(count);
  ProxyError error;
  error.known = true;
  error.of.resize(count);
  error.depth.resize(count);
  error.turn.resize(count);
  VecX dx = VecX::Zero(n_x);
  std::vector<MapBlock> touched;
  for (int i = 0; i < count; ++i) {
    MapBlock at = blocks[random() % blocks.size()];
    if (random() % 8 == 0) at = {&map};  // of all blocks
    touched.push_back(at);
    used.into.col(i).segment(at.first_x, at.n_x()) = direction(random, at.n_x());
    used.depth[i] = drawn(random, -0.5, 2.0) * band;
    error.of[i] = std::pow(10.0, drawn(random, -6.0, -3.0));
    error.depth[i] = std::pow(10.0, drawn(random, -4.0, 0.0)) * band;
    error.turn[i] = std::pow(10.0, drawn(random, -4.0, -1.0));
    if (random() % 8 == 0) error.beside |= 1u << i;
    if (random() % 4 == 0) continue;  // nothing displaces this block by itself
    dx.segment(at.first_x, at.n_x()) +=
        drawn(random, 0.0, 3.0) * kDegree * direction(random, at.n_x());
  }
  const VecA limit = VecA::Constant(n_a, 1e4);
  Projection out;
  const auto force = [&](BlockRenderer& by, const VecX& at, const Contacts& contacts) {
    by.project({q, x_probe, J, {&contacts, &limit}}, x_probe + at, at, stiffness, true, out);
    return VecA(stiffness.cwiseProduct(map.layout().select(out.q_star) - map.layout().select(q)));
  };
  const VecA here = force(renderer, dx, used);
  const bool held_back = out.contradicted;
  VecA bound;
  bool known = false;
  {
    const test::AllocationGuard guard;
    known = force_error.at({RendererKind::kPerContact, q, stiffness, {}, J}, used, error, bound) &&
            renderer.widen({q, x_probe, J, {&used, &limit}}, dx, stiffness, error, bound);
    EXPECT_EQ(guard.allocations(), 0u);
  }
  ++tally.trials;
  tally.known += known ? 1 : 0;
  tally.held_back += held_back ? 1 : 0;
  tally.held_back_known += held_back && known ? 1 : 0;
  if (!known) return;
  BlockRenderer true_renderer(RendererKind::kPerContact, model);
  double worst = 0.0;
  for (int way = 0; way < 40; ++way) {
    Contacts truth = used;
    VecX off = VecX::Zero(n_x);
    const double reach = way % 2 == 0 ? 1.0 : drawn(random, 0.0, 1.0);
    for (int i = 0; i < count; ++i) {
      const MapBlock& at = touched[static_cast<std::size_t>(i)];
      off.segment(at.first_x, at.n_x()) += reach * error.of[i] * direction(random, at.n_x());
      truth.depth[i] += error.depth[i] * (way % 3 == 0        ? drawn(random, -1.0, 1.0)
                                          : random() % 2 == 0 ? 1.0
                                                              : -1.0);
      const bool missing = (error.beside >> i & 1u) != 0 && random() % 2 == 0;
      if (missing) truth.depth[i] = -1.0;
      auto into = truth.into.col(i).segment(at.first_x, at.n_x());
      into = (into + reach * error.turn[i] * direction(random, at.n_x())).normalized();
      if ((into - used.into.col(i).segment(at.first_x, at.n_x())).norm() > error.turn[i]) {
        into = used.into.col(i).segment(at.first_x, at.n_x());
      }
    }
    const VecA there = force(true_renderer, dx + off, truth);
    for (int a = 0; a < n_a; ++a) {
      ASSERT_LE(std::abs(there[a] - here[a]), bound[a] + 1e-9 * (1.0 + std::abs(here[a])))
          << tally.trials << ", actuator " << a << " of " << n_a;
      if (bound[a] > 1e-9) worst = std::max(worst, std::abs(there[a] - here[a]) / bound[a]);
    }
  }
  if (worst > 0.0) tally.ratios.push_back(1.0 / worst);
}

void report(const char* what, const Tally& tally) {
  std::printf("%s: %d trials, %d known, of %d held back %d known; bound by error: median %.2f\n",
              what, tally.trials, tally.known, tally.held_back, tally.held_back_known,
              middle(tally.ratios));
}

TEST(PerContactError, BoundsOneActuator) {
  Random random(3);
  Tally tally;
  for (int trial = 0; trial < 3000; ++trial) {
    const auto map = map_of_angles(random, trial % 2 == 0 ? 2 : 6, 2, 1);
    judge(*map, VecQ::Zero(2), random, tally);
    if (HasFatalFailure()) return;
  }
  report("one actuator", tally);
  EXPECT_EQ(tally.known, tally.trials);
  EXPECT_GT(tally.held_back, 500);
  EXPECT_LT(middle(tally.ratios), 2.0);
}

TEST(PerContactError, BoundsTwoFingers) {
  const auto hand = make_hand_exoskeleton(
      {{"index", finger_sign_change()}, {"middle", scaled(finger_sign_change(), 1.1)}});
  Random random(4);
  Tally tally;
  for (int trial = 0; trial < 2000; ++trial) {
    VecX x(4);
    for (int i = 0; i < 4; ++i) x[i] = drawn(random, 10.0, 50.0) * kDegree;
    VecQ q;
    if (hand->inverse(x, q) != InverseStatus::kExact) continue;
    judge(*hand, q, random, tally);
    if (HasFatalFailure()) return;
  }
  report("two fingers", tally);
  EXPECT_EQ(tally.known, tally.trials);
  EXPECT_GT(tally.held_back, 300);
  EXPECT_LT(middle(tally.ratios), 2.0);
}

TEST(PerContactError, BoundsSeveralActuatorsUnlessHeldBack) {
  Random random(5);
  Tally tally;
  for (int trial = 0; trial < 3000; ++trial) {
    const auto map =
        trial % 2 == 0 ? map_of_angles(random, 6, 6, 3) : map_of_angles(random, 7, 3, 2);
    judge(*map, VecQ::Zero(map->layout().n_q()), random, tally);
    if (HasFatalFailure()) return;
  }
  report("several actuators", tally);
  EXPECT_EQ(tally.held_back_known, 0);
  EXPECT_GT(tally.known, tally.trials / 4);
}

}  // namespace
}  // namespace haptic::core::per_contact_error_test
