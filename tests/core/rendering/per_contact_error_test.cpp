// Eq. (39) at the actuators (core/METHOD.md#error-bound), by brute force: each renderer at the
// proxy and the contacts in use, and at any to which these may be off.
#include "haptic/core/rendering/force_error.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "haptic/core/model/hand_exoskeleton.hpp"
#include "haptic/core/rendering/block_renderer.hpp"
#include "tests/core/model/sample_maps.hpp"
#include "tests/core/rendering/every_renderer.hpp"
#include "tests/support/allocation_guard.hpp"
#include "tests/support/angles.hpp"
#include "tests/support/dense_oracle.hpp"
#include "tests/support/percentile.hpp"

namespace haptic::core::per_contact_error_test {
namespace {

using Random = std::mt19937_64;

constexpr RendererKind kRule = RendererKind::kPerContact;

double drawn(Random& random, double lowest, double highest) {
  return std::uniform_real_distribution<double>(lowest, highest)(random);
}

VecX direction(Random& random, Eigen::Index n) {
  std::normal_distribution<double> normal;
  VecX v = VecX::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) v[i] = normal(random);
  return v.normalized();
}

/// Well-conditioned, of angles.
std::unique_ptr<Kinematics> map_of_angles(Random& random, int n_x, int n_q, int n_a) {
  Eigen::MatrixXd A(n_x, n_q);
  do {
    for (int i = 0; i < n_q; ++i) A.col(i) = direction(random, n_x);
  } while (oracle::condition(A) > 30.0);
  return samples::linear_map(A, n_a, 1e6, Unit::kRadian);
}

struct Tally {
  std::vector<double> ratios{};  ///< of the bound to the error
  int trials{0}, known{0}, held_back{0}, held_back_known{0};
};

/// A proxy up to 3 degrees off the probe, up to four contacts about their band, and how far these
/// may be off.
struct InUse {
  InUse(Random& random, RendererKind kind, const ProjectionModel& model) {
    const std::vector<MapBlock> blocks = model.blocks();
    const double band = contact_band(model);
    const int count = 1 + static_cast<int>(random() % 4);
    contacts.into = MatXQ::Zero(model.n_x(), count);
    for (auto* each : {&contacts.depth, &error.of, &error.depth, &error.turn}) each->resize(count);
    error.known = true;
    dx = VecX::Zero(model.n_x());
    for (int i = 0; i < count; ++i) {
      MapBlock at = blocks[random() % blocks.size()];
      if (random() % 8 == 0) at = {&model.kinematics()};  // of all blocks
      touched.push_back(at);
      contacts.into.col(i).segment(at.first_x, at.n_x()) = direction(random, at.n_x());
      contacts.depth[i] = drawn(random, -0.5, 2.0) * band;
      // The other renderers are linearised.
      error.of[i] = std::pow(10.0, drawn(random, -6.0, kind == kRule ? -3.0 : -4.0));
      error.depth[i] = std::pow(10.0, drawn(random, -4.0, 0.0)) * band;
      error.turn[i] = std::pow(10.0, drawn(random, -4.0, -1.0));
      if (random() % 8 == 0) error.beside |= 1u << i;
      if (random() % 4 == 0) continue;  // nothing displaces this block by itself
      dx.segment(at.first_x, at.n_x()) +=
          drawn(random, 0.0, 3.0) * kDegree * direction(random, at.n_x());
    }
    if (kind != kRule && count == 1) error.along = 0;
  }
  /// A truth that these errors allow, `reach` of what they allow: adds to x what it is off.
  Contacts truth(Random& random, double reach, VecX& x) const {
    Contacts truth = contacts;
    for (int i = 0; i < contacts.size(); ++i) {
      const MapBlock& at = touched[static_cast<std::size_t>(i)];
      auto into = truth.into.col(i).segment(at.first_x, at.n_x());
      const VecX before = into;
      x.segment(at.first_x, at.n_x()) +=
          reach * error.of[i] * (error.along == 0 ? before : direction(random, at.n_x()));
      truth.depth[i] += error.depth[i] * (random() % 3 == 0   ? drawn(random, -1.0, 1.0)
                                          : random() % 2 == 0 ? 1.0
                                                              : -1.0);
      if ((error.beside >> i & 1u) != 0 && random() % 2 == 0) truth.depth[i] = -1.0;
      into = (before + reach * error.turn[i] * direction(random, at.n_x())).normalized();
      if ((into - before).norm() > error.turn[i]) into = before;
    }
    return truth;
  }

  Contacts contacts{};
  ProxyError error{};
  VecX dx{};
  std::vector<MapBlock> touched{};
};

/// At a pose.
void judge(RendererKind kind, const Kinematics& map, const VecQ& q, Random& random, Tally& tally) {
  const ProjectionModel model(map);
  BlockRenderer renderer(kind, model), true_renderer(kind, model);
  ForceError force_error(model);
  const int n_a = map.layout().n_a();
  VecA stiffness(n_a);
  for (double& k : stiffness) k = drawn(random, 300.0, 3000.0);
  const VecA limit = VecA::Constant(n_a, 1e4);
  const InUse used(random, kind, model);
  VecX x;
  ASSERT_EQ(map.position(q, x), MapStatus::kOk);
  x += used.dx;
  Projection out;
  const auto force = [&](BlockRenderer& by, const VecX& at, const Contacts& contacts) {
    out = projected(by, Instant(map, q, at), stiffness, true, {&contacts, &limit});
    return spring_force(map.layout(), out, q, stiffness);
  };
  const VecA here = force(renderer, x, used.contacts);
  const bool held_back = out.contradicted;
  const Instant at(map, q, x);
  VecA bound;
  bool known = false;
  {
    const test::AllocationGuard guard;
    known =
        force_error.at({kind, q, stiffness, {}, at.J}, used.contacts, used.error, bound) &&
        renderer.widen(at.probe({&used.contacts, &limit}), used.dx, stiffness, used.error, bound);
    EXPECT_EQ(guard.allocations(), 0u);
  }
  ++tally.trials;
  tally.known += known ? 1 : 0;
  tally.held_back += held_back ? 1 : 0;
  tally.held_back_known += held_back && known ? 1 : 0;
  if (!known) return;
  const double exactly = kind == kRule ? 1.0 : 1.02;
  double worst = 0.0;
  for (int way = 0; way < 40; ++way) {
    VecX off = x;
    const double reach = way % 2 == 0 ? 1.0 : drawn(random, 0.0, 1.0);
    const Contacts truth = used.truth(random, reach, off);
    const VecA there = force(true_renderer, off, truth);
    for (int a = 0; a < n_a; ++a) {
      const double moved = std::abs(there[a] - here[a]);
      ASSERT_LE(moved, exactly * bound[a] + 1e-9 * (1.0 + std::abs(here[a])))
          << tally.trials << ", actuator " << a << " of " << n_a;
      if (bound[a] > 1e-9) worst = std::max(worst, moved / bound[a]);
    }
  }
  if (worst > 0.0) tally.ratios.push_back(1.0 / worst);
}

/// At poses of two fingers.
void judge_fingers(RendererKind kind, int trials, Random& random, Tally& tally) {
  static const auto hand = make_hand_exoskeleton(
      {{"index", finger_sign_change()}, {"middle", scaled(finger_sign_change(), 1.1)}});
  for (int trial = 0; trial < trials; ++trial) {
    VecX x(4);
    for (double& joint : x) joint = drawn(random, 10.0, 50.0) * kDegree;
    VecQ q;
    if (hand->inverse(x, q) != InverseStatus::kExact) continue;
    judge(kind, *hand, q, random, tally);
    if (testing::Test::HasFatalFailure()) return;
  }
}

void report(const char* what, const Tally& tally) {
  std::printf("%s: %d trials, %d known, of %d held back %d known; bound by error: median %.2f\n",
              what, tally.trials, tally.known, tally.held_back, tally.held_back_known,
              test::percentile(tally.ratios, 0.5));
}

TEST(PerContactError, BoundsOneActuator) {
  Random random(3);
  Tally tally;
  for (int trial = 0; trial < 3000; ++trial) {
    const auto map = map_of_angles(random, trial % 2 == 0 ? 2 : 6, 2, 1);
    judge(kRule, *map, VecQ::Zero(2), random, tally);
    if (HasFatalFailure()) return;
  }
  report("one actuator", tally);
  EXPECT_EQ(tally.known, tally.trials);
  EXPECT_GT(tally.held_back, 500);
  EXPECT_LT(test::percentile(tally.ratios, 0.5), 2.0);
}

TEST(PerContactError, BoundsTwoFingers) {
  Random random(4);
  Tally tally;
  judge_fingers(kRule, 2000, random, tally);
  report("two fingers", tally);
  EXPECT_EQ(tally.known, tally.trials);
  EXPECT_GT(tally.held_back, 300);
  EXPECT_LT(test::percentile(tally.ratios, 0.5), 2.0);
}

TEST(ForceError, BoundsEveryRenderer) {
  for (const RendererKind kind : kEveryRenderer) {
    SCOPED_TRACE(std::string(name(kind)));
    Random random(4);
    Tally tally;
    judge_fingers(kind, 300, random, tally);
    const bool linearised = kind != RendererKind::kSubspaceExact;
    EXPECT_EQ(tally.known, linearised ? tally.trials : 0);
    if (!linearised) continue;
    EXPECT_LT(*std::min_element(tally.ratios.begin(), tally.ratios.end()), 1.25)
        << "or the bound is vacuous";
  }
}

/// Nothing touches the second finger.
TEST(ForceError, IsNothingOfAnUntouchedFinger) {
  const auto hand = make_hand_exoskeleton({{"a", finger_sign_change()}, {"b", {}}});
  VecQ q;
  ASSERT_EQ(hand->inverse(VecX::Constant(4, 0.5), q), InverseStatus::kExact);
  Contacts contacts;
  contacts.into = VecX::Unit(4, 0);
  contacts.depth = VecX::Ones(1);
  ProxyError error;
  error.known = true;
  error.of = VecX::Constant(1, 1e-4);
  const VecA stiffness = VecA::Constant(2, 900.0);
  VecA bound;
  ASSERT_TRUE(ForceError(*hand).at({RendererKind::kSubspaceLinear, q, stiffness, {}, {}}, contacts,
                                   error, bound));
  EXPECT_GT(bound[0], 0.0);
  EXPECT_EQ(bound[1], 0.0);
}

TEST(PerContactError, BoundsSeveralActuatorsUnlessHeldBack) {
  Random random(5);
  Tally tally;
  for (int trial = 0; trial < 3000; ++trial) {
    const auto map =
        trial % 2 == 0 ? map_of_angles(random, 6, 6, 3) : map_of_angles(random, 7, 3, 2);
    judge(kRule, *map, VecQ::Zero(map->layout().n_q()), random, tally);
    if (HasFatalFailure()) return;
  }
  report("several actuators", tally);
  EXPECT_EQ(tally.held_back_known, 0);
  EXPECT_GT(tally.known, tally.trials / 4);
}

}  // namespace
}  // namespace haptic::core::per_contact_error_test
