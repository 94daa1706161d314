#include "haptic/core/rendering/linear_certificate.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/hand_exoskeleton.hpp"
#include "haptic/core/model/linear.hpp"
#include "haptic/core/model/stylus.hpp"
#include "haptic/core/rendering/subspace_linear.hpp"
#include "tests/report/analysis/passivity_radius.hpp"

namespace haptic::core {
namespace {

struct Case {
  VecQ q{};
  VecX x{}, x_probe{}, dx{};
  MatXQ J{};
  VecA Z_q{};
  [[nodiscard]] Probe probe() const { return {q, x_probe, J}; }
};

/// A pose of the box where f has a value, a proxy up to `far` per coordinate away, stiffnesses that
/// differ by up to 30.
class Cases {
 public:
  Cases(const Kinematics& map, double far) : map_(map), far_(far) {}
  Case next() {
    Case c;
    do c.q = workspace_sample(map_, n_++);
    while (map_.evaluate(c.q, c.x_probe, c.J) != MapStatus::kOk);
    std::uniform_real_distribution<double> shift(-far_, far_), stiff(100.0, 3000.0);
    c.x = c.x_probe;
    for (double& x : c.x) x += shift(random_);
    map_.space().difference(c.x, c.x_probe, c.dx);
    c.Z_q = VecA::Zero(map_.layout().n_a());
    for (double& k : c.Z_q) k = stiff(random_);
    return c;
  }

 private:
  const Kinematics& map_;
  double far_;
  int n_{0};
  std::mt19937_64 random_{7};
};

std::vector<ChainOutput>
three_marks() {  // three points that are not in a line: nine coordinates of six DoFs
  return {{"tip", "", OutputKind::kPoint, {{0.03, 0, 0}, {}}},
          {"end", "", OutputKind::kPoint, {{-0.10, 0, 0}, {}}},
          {"button", "", OutputKind::kPoint, {{0, 0, 0.03}, {}}}};
}

double offline(const Kinematics& map, const Case& c) {
  const RenderingImpedance impedance{c.Z_q, MatXX::Identity(c.x.size(), c.x.size())};
  return passivity_certificate(RendererKind::kSubspaceLinear, map, c.q, c.x, impedance)
      .value()
      .margin;
}

/// Returns how many margins were not above 0.
int expect_offline_margins(const Kinematics& map, double far, int poses) {
  LinearCertificate live{ProjectionModel(map)};
  Cases cases(map, far);
  int lost = 0;
  for (int i = 0; i < poses; ++i) {
    const Case c = cases.next();
    const Certificate found = live.at(c.probe(), c.dx, c.Z_q);
    EXPECT_EQ(found.status, CertificateStatus::kComputed);
    EXPECT_EQ(found.block, 0);
    const double want = offline(map, c);
    EXPECT_NEAR(found.margin, want, 1e-9 * (1.0 + std::abs(want))) << i;
    lost += found.margin <= 0.0;
  }
  return lost;
}

TEST(LinearCertificate, IsTheFingersOfflineMargin) {
  EXPECT_GT(expect_offline_margins(*make_finger_exoskeleton(finger_sign_change()), 0.5, 300), 10)
      << "at deviations up to 30 deg some margins are lost";
}

/// More coordinates than DoFs and three actuators: the residual's term and the eigenvalue count.
TEST(LinearCertificate, IsTheStylussOfflineMargin) {
  EXPECT_GT(expect_offline_margins(*make_stylus({}, three_marks()), 0.1, 200), 10);
}

TEST(LinearCertificate, OfALinearMapIsOne) {
  LinearMap map;
  for (const char* name : {"a", "b", "c"}) map.dofs.push_back({name, Unit::kMetre, name[0] != 'c'});
  for (DofSpec& dof : map.dofs) dof.lower = -(dof.upper = 1.0);
  for (const char* name : {"u", "v", "w", "s"}) map.coordinates.push_back({name, Unit::kMetre});
  map.A = (MatXQ(4, 3) << 1, 2, 0, -1, 1, 3, 0.5, 0, 1, 2, 2, -1).finished();
  const auto linear = make_linear(map);
  LinearCertificate live{ProjectionModel(*linear)};
  Cases cases(*linear, 2.0);
  for (int i = 0; i < 20; ++i) {
    const Case c = cases.next();
    EXPECT_NEAR(live.at(c.probe(), c.dx, c.Z_q).margin, 1.0, 1e-14);
  }
}

/// Each block alone has the offline margin of a finger; the record names the worst of the
/// displaced.
TEST(LinearCertificate, HandTakesItsWorstDisplacedFinger) {
  const std::vector<HandFinger> fingers{{"thumb", scaled(finger_sign_change(), 0.8)},
                                        {"index", finger_sign_change()},
                                        {"middle", finger_sign_change()}};
  const auto hand = make_hand_exoskeleton(fingers);
  std::vector<std::unique_ptr<Kinematics>> alone_maps;
  for (const HandFinger& finger : fingers) {
    alone_maps.push_back(make_finger_exoskeleton(finger.dimensions));
  }
  LinearCertificate live{ProjectionModel(*hand)};
  Cases cases(*hand, 0.4);
  int named[3] = {0, 0, 0};
  for (int i = 0; i < 120; ++i) {
    Case c = cases.next();
    const int idle = i % 4;  // 3: none
    for (int k = 2 * idle; k < std::min(6, 2 * idle + 2); ++k) c.dx[k] = 0.0;
    double worst = 1e300;
    int at = -1;
    for (int f = 0; f < 3; ++f) {
      if (f == idle) continue;
      Case alone;
      alone.q = c.q.segment(2 * f, 2);
      alone.x = c.x.segment(2 * f, 2);
      alone.Z_q = c.Z_q.segment(f, 1);
      const double margin = offline(*alone_maps[static_cast<std::size_t>(f)], alone);
      if (margin < worst) {
        worst = margin;
        at = f;
      }
    }
    const Certificate found = live.at(c.probe(), c.dx, c.Z_q);
    ASSERT_EQ(found.status, CertificateStatus::kComputed);
    EXPECT_EQ(found.block, at);
    EXPECT_NEAR(found.margin, worst, 1e-9 * (1.0 + std::abs(worst)));
    ++named[at];
  }
  for (const int count : named) EXPECT_GT(count, 5) << "every finger was the worst at times";
}

/// With a metric there is no offline word: the renderer itself, differenced at q +- h with x held.
TEST(LinearCertificate, MetricGivesTheRenderersOwnDerivative) {
  const auto stylus = make_stylus({});  // a frame: metres and quaternion parts
  VecX scale(7);
  scale << 0.005, 0.005, 0.005, 0.05, 0.05, 0.05, 0.05;
  const ProjectionModel model(*stylus, {TaskMetric::from_scales(scale), {}, {}});
  LinearCertificate live(model);
  SubspaceLinear renderer(model);
  const DofLayout& layout = stylus->layout();
  Cases cases(*stylus, 0.05);
  const auto S_dq = [&](const VecQ& q, const VecX& x, const VecA& Z_q) {
    VecX x_probe, dx(7);
    MatXQ J;
    EXPECT_EQ(stylus->evaluate(q, x_probe, J), MapStatus::kOk);
    stylus->space().difference(x, x_probe, dx);
    Projection out;
    renderer.project({q, x_probe, J}, {}, dx, Z_q, true, out);
    return layout.select(out.q_star - q);
  };
  for (int i = 0; i < 40; ++i) {
    const Case c = cases.next();
    Eigen::Matrix3d felt;  // -d tau_a/dq_a, whitened by Z_q
    constexpr double kStep = 1e-5;
    for (int k = 0; k < 3; ++k) {
      const VecQ step = kStep * VecQ::Unit(6, layout.actuated(k));
      const VecA slope =
          (S_dq(c.q + step, c.x, c.Z_q) - S_dq(c.q - step, c.x, c.Z_q)) / (2.0 * kStep);
      for (int j = 0; j < 3; ++j) felt(j, k) = -std::sqrt(c.Z_q[j] / c.Z_q[k]) * slope[j];
    }
    const Eigen::Matrix3d symmetric = 0.5 * (felt + felt.transpose());
    const double want = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(symmetric).eigenvalues()[0];
    EXPECT_NEAR(live.at(c.probe(), c.dx, c.Z_q).margin, want, 1e-6 * (1.0 + std::abs(want)));
  }
}

TEST(LinearCertificate, SaysWhyThereIsNone) {
  const auto finger = make_finger_exoskeleton(finger_sign_change());
  LinearCertificate live{ProjectionModel(*finger)};
  Case c = Cases(*finger, 0.2).next();
  EXPECT_EQ(live.at(c.probe(), VecX::Zero(2), c.Z_q).status, CertificateStatus::kIdle);
  EXPECT_EQ(live.at(c.probe(), c.dx, VecA::Zero(1)).status, CertificateStatus::kNoStiffness);
  Case flat = c;
  flat.J.col(1) = 2.0 * flat.J.col(0);
  EXPECT_EQ(live.at(flat.probe(), c.dx, c.Z_q).status, CertificateStatus::kNotFullRank);
  flat.J(0, 0) = std::nan("");
  EXPECT_EQ(live.at(flat.probe(), c.dx, c.Z_q).status, CertificateStatus::kNotFullRank);
  Case open = c;
  open.q << 0.0, -0.588;  // D opposite of P: |D| = 14 mm, below h1 (core/METHOD.md#forward-map)
  EXPECT_EQ(live.at(open.probe(), c.dx, c.Z_q).status, CertificateStatus::kMapFailed);
}

/// What cannot be judged is not covered by another block's margin.
TEST(LinearCertificate, NamesTheBlockWithoutOne) {
  const auto hand =
      make_hand_exoskeleton({{"thumb", finger_sign_change()}, {"index", finger_sign_change()}});
  LinearCertificate live{ProjectionModel(*hand)};
  Case c = Cases(*hand, 0.1).next();
  c.J.block(2, 3, 2, 1) = 3.0 * c.J.block(2, 2, 2, 1);
  const Certificate found = live.at(c.probe(), c.dx, c.Z_q);
  EXPECT_EQ(found.status, CertificateStatus::kNotFullRank);
  EXPECT_EQ(found.block, 1);
}

TEST(LinearCertificate, IsRefusedWithAPrior) {
  const auto stylus = make_stylus({}, three_marks());
  ProjectionSettings settings;
  settings.prior = Prior{1.0, VecQ::Ones(3)};
  const ProjectionModel model(*stylus, settings);
  EXPECT_THROW(LinearCertificate{model}, SceneError);
}

}  // namespace
}  // namespace haptic::core
