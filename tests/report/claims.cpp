/// haptic-report claims: what the paper's sections IV and V.C say of the displayed impedance, tried
/// on other devices than one finger: how often it holds, and where it fails
/// (tests/report/STUDY.md#the-claims-on-other-devices).
#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <random>

#include "haptic/core/model/hand_exoskeleton.hpp"
#include "haptic/core/model/serial_chain.hpp"
#include "haptic/core/model/stylus.hpp"
#include "tests/report/analysis/displayed_impedance.hpp"
#include "tests/report/analysis/linkage_quality.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/values.hpp"
#include "tests/support/percentile.hpp"

namespace haptic::report {
namespace {

using core::MatAQ;
using core::RendererKind;
using Matrix = Eigen::MatrixXd;
using Random = std::mt19937_64;
using Map = std::shared_ptr<const core::Kinematics>;

constexpr int kStates = 1000;                         // per device and size of the deviation
constexpr double kDeviations[] = {0.02, 0.10, 0.30};  // of every DoF's range
constexpr double kResidual = 0.3;                     // of x beyond f's image, of the deviation
constexpr double kRounding = 1e-9;
constexpr int kRandomLinkages = 24;

double uniform(Random& random, double lower = -1.0, double upper = 1.0) {
  return lower + (upper - lower) * static_cast<double>(random() >> 11U) * 0x1p-53;
}

struct Device {
  std::string name;
  std::vector<Map> maps;  ///< states are spread over them
};

Map arm() {
  core::SerialChainParameters chain;
  for (const char* name : {"shoulder", "elbow", "wrist"}) {
    core::ChainJoint joint;
    joint.name = name;
    joint.actuated = std::string(name) != "wrist";
    if (joint.name != "shoulder") joint.origin.position = {0.2, 0.0, 0.0};
    joint.lower = joint.name == "shoulder" ? -1.0 : 0.3;
    joint.upper = joint.name == "shoulder" ? 1.0 : 1.8;
    chain.joints.push_back(joint);
  }
  chain.outputs.push_back({"wrist", "elbow", core::OutputKind::kPoint, {{0.2, 0.0, 0.0}, {}}});
  chain.outputs.push_back({"tip", "wrist", core::OutputKind::kPoint, {{0.1, 0.0, 0.0}, {}}});
  return core::make_serial_chain(chain);
}

/// Three points of the pen fix its six joints.
Map stylus() {
  std::vector<core::ChainOutput> points;
  points.push_back({"tip", "gimbal_roll", core::OutputKind::kPoint, {{0.03, 0.0, 0.0}, {}}});
  points.push_back({"side", "gimbal_roll", core::OutputKind::kPoint, {{0.0, 0.03, 0.0}, {}}});
  points.push_back({"back", "gimbal_roll", core::OutputKind::kPoint, {{-0.05, 0.0, 0.03}, {}}});
  return core::make_stylus({}, points);
}

Map hand() {
  std::vector<core::HandFinger> fingers;
  for (const auto& [name, size] :
       {std::pair{"index", 1.0}, {"middle", 1.1}, {"ring", 1.0}, {"little", 0.75}}) {
    fingers.push_back({name, core::scaled({}, size)});
  }
  return core::make_hand_exoskeleton(fingers);
}

/// Linkages that reach at least nine tenths of the workspace, whatever their sign.
std::vector<Map> random_linkages() {
  Random random(19);
  std::vector<Map> maps;
  while (static_cast<int>(maps.size()) < kRandomLinkages) {
    core::FingerDimensions d = core::finger_sign_change();
    d.rail_origin = {uniform(random, -0.03, 0.01), uniform(random, -0.02, 0.02)};
    d.rail_angle = uniform(random, 20 * kDegree, 100 * kDegree);
    d.body_d = {uniform(random, 0.015, 0.04), 0.0};
    d.body_e = {uniform(random, 0.05, 0.1), uniform(random, -0.05, 0.0)};
    d.rod1 = uniform(random, 0.01, 0.025);
    d.rod2 = uniform(random, 0.01, 0.025);
    d.l_x_lower = -0.02;
    d.l_x_upper = 0.06;
    d.q_B_lower = -120 * kDegree;
    d.q_B_upper = 80 * kDegree;
    if (core::linkage_quality(d, 5.0).reach < 0.9) continue;
    maps.push_back(core::make_finger_exoskeleton(d));
  }
  return maps;
}

std::vector<Device> devices() {
  return {{"finger_same_sign", {core::make_finger_exoskeleton({})}},
          {"finger_sign_change", {core::make_finger_exoskeleton(core::finger_sign_change())}},
          {std::to_string(kRandomLinkages) + " random linkages", random_linkages()},
          {"arm 2 of 3", {arm()}},
          {"stylus 3 of 6", {stylus()}},
          {"hand 4 of 8", {hand()}}};
}

/// A device displaced from its proxy. Lengths of q are its ranges, so that no unit decides.
struct State {
  core::VecQ q, range;
  core::VecX x;
  core::MatXQ J;
};

/// Fingers within their workspace; others anywhere in their box.
bool draw_pose(const core::Kinematics& map, Random& random, core::VecQ& q) {
  const int n_x = map.space().n_x(), n_q = map.layout().n_q();
  q.resize(n_q);
  core::VecX goal(n_x);
  for (int i = 0; i + 1 < n_x; i += 2) {
    goal[i] = uniform(random, 0.0, 80 * kDegree);
    goal[i + 1] = uniform(random, 0.0, 90 * kDegree);
  }
  if (!map.blocks().empty()) {  // a hand: each finger by itself
    for (const core::MapBlock& block : map.blocks()) {
      core::VecQ finger;
      if (!draw_pose(*block.kinematics, random, finger)) return false;
      q.segment(block.first_q, block.n_q()) = finger;
    }
    return true;
  }
  const core::InverseStatus status = map.inverse(goal, q);
  if (status != core::InverseStatus::kNotOffered) return status == core::InverseStatus::kExact;
  for (int i = 0; i < n_q; ++i) {
    const core::DofSpec& dof = map.dofs()[static_cast<std::size_t>(i)];
    q[i] = uniform(random, dof.lower, dof.upper);
  }
  return true;
}

State draw(const core::Kinematics& map, double deviation, Random& random) {
  State s;
  const int n_q = map.layout().n_q();
  s.range.resize(n_q);
  for (int i = 0; i < n_q; ++i) {
    const core::DofSpec& dof = map.dofs()[static_cast<std::size_t>(i)];
    s.range[i] = dof.upper - dof.lower;
  }
  for (;;) {
    core::VecX x_probe;
    if (!draw_pose(map, random, s.q) || map.evaluate(s.q, x_probe, s.J) != core::MapStatus::kOk) {
      continue;
    }
    core::VecQ moved = s.q;
    for (int i = 0; i < n_q; ++i) moved[i] += deviation * s.range[i] * uniform(random);
    if (map.position(moved, s.x) != core::MapStatus::kOk) continue;
    core::VecX beside(s.x.size());
    for (int i = 0; i < beside.size(); ++i) beside[i] = uniform(random);
    if (s.x.size() > n_q) s.x += kResidual * (s.x - x_probe).norm() * beside.normalized();
    return s;
  }
}

/// Symmetric, positive definite, with eigenvalues from 0.1 to 10.
core::MatXX general_Z_x(int n_x, Random& random) {
  Matrix A(n_x, n_x);
  for (int i = 0; i < n_x; ++i)
    for (int k = 0; k < n_x; ++k) A(i, k) = uniform(random);
  const Matrix Q = Eigen::HouseholderQR<Matrix>(A).householderQ();
  Eigen::VectorXd e(n_x);
  for (int i = 0; i < n_x; ++i) e[i] = std::pow(10.0, uniform(random));
  return Q * e.asDiagonal() * Q.transpose();
}

/// d tau_a/dq, n_a by n_q, in units of the ranges.
Matrix scaled(const MatAQ& impedance, const core::Kinematics& map, const core::VecQ& range) {
  return map.layout().select(range).asDiagonal() * impedance * range.asDiagonal();
}

struct Judged {
  bool negative{false};      ///< d tau_a/dq_a, its symmetric part
  bool no_sensed{false};     ///< d tau_a/dq_n = 0
  bool conservative{false};  ///< no work around any small loop: d tau/dq symmetric
  double curl{0.0};          ///< of small loops: work over what the spring itself takes and gives
  double largest{0.0};       ///< eigenvalue of the symmetric part over the largest magnitude
};

Judged judge(const Matrix& impedance, const core::DofLayout& layout) {
  const int n_a = layout.n_a(), n_q = layout.n_q();
  Matrix a(n_a, n_a), D = Matrix::Zero(n_q, n_q);
  for (int i = 0; i < n_a; ++i) {
    a.col(i) = impedance.col(layout.actuated(i));
    D.row(layout.actuated(i)) = impedance.row(i);
  }
  const Eigen::VectorXd e =
      Eigen::SelfAdjointEigenSolver<Matrix>(0.5 * (a + a.transpose())).eigenvalues();
  const double norm = std::max(D.norm(), 1e-300);
  const double sensed = std::max(0.0, D.squaredNorm() - a.squaredNorm());
  return {.negative = e.maxCoeff() < 0.0,
          .no_sensed = std::sqrt(sensed) < 1e-7 * norm,
          .conservative = (D - D.transpose()).norm() < kRounding * norm,
          .curl = (D - D.transpose()).norm() / std::max((D + D.transpose()).norm(), 1e-300),
          .largest = e.maxCoeff() / e.cwiseAbs().maxCoeff()};
}

/// The shares of the states in which each claim holds, and the state in which it fails most.
struct Tally {
  int states{0}, negative{0}, no_sensed{0}, conservative{0};
  double worst{-1.0};
  std::string where{"-"};
  std::vector<double> curls{};
  void add(const Judged& j, const State& s) {
    ++states;
    negative += j.negative ? 1 : 0;
    no_sensed += j.no_sensed ? 1 : 0;
    conservative += j.conservative ? 1 : 0;
    curls.push_back(j.curl);
    if (j.largest <= worst) return;
    worst = j.largest;
    where.clear();
    for (int i = 0; i < s.q.size(); ++i) {
      char text[32];
      std::snprintf(text, sizeof text, "%s%.4g", i == 0 ? "" : " ", s.q[i]);
      where += text;
    }
  }
};

core::RenderingImpedance impedance_of(const core::Kinematics& map, const State& s, bool general,
                                      Random& random) {
  core::RenderingImpedance z;
  z.Z_q = map.layout().select(s.range).array().square().inverse();
  const int n_x = map.space().n_x();
  z.Z_x = general ? general_Z_x(n_x, random) : core::MatXX(core::MatXX::Identity(n_x, n_x));
  return z;
}

void print_tally(const Device& device, const char* formula, const char* Z_x, double deviation,
                 RendererKind kind, const Tally& t) {
  const core::DofLayout& layout = device.maps.front()->layout();
  const auto share = [&](int n) { return 100.0 * n / std::max(t.states, 1); };
  row(device.name, layout.n_a(), layout.n_q() - layout.n_a(), device.maps.front()->space().n_x(),
      formula, Z_x, deviation, core::name(kind), t.states, share(t.negative), share(t.no_sensed),
      share(t.conservative), 100.0 * test::percentile(t.curls, 0.5), t.worst, t.where);
}

void print_device(const Device& device) {
  for (const bool general : {false, true}) {
    for (const double deviation : kDeviations) {
      for (const RendererKind kind : kMethods) {
        const bool subspace =
            kind == RendererKind::kSubspaceLinear || kind == RendererKind::kSubspaceExact;
        if (general && subspace) continue;  // they have no Z_x
        Random random(7);
        Tally theory, exact;
        for (int i = 0; i < kStates; ++i) {
          const core::Kinematics& map =
              *device.maps[static_cast<std::size_t>(i) % device.maps.size()];
          const State s = draw(map, deviation, random);
          const core::RenderingImpedance z = impedance_of(map, s, general, random);
          const auto formula = core::theoretical_impedance(kind, map, s.q, z);
          const auto true_one = core::exact_impedance(kind, map, s.q, s.x, z);
          if (formula) theory.add(judge(scaled(*formula, map, s.range), map.layout()), s);
          if (true_one) exact.add(judge(scaled(*true_one, map, s.range), map.layout()), s);
        }
        const char* Z_x = subspace ? "-" : general ? "general" : "k I";
        // The formulas do not see the proxy: once is enough.
        if (deviation == kDeviations[0]) print_tally(device, "paper", Z_x, 0.0, kind, theory);
        print_tally(device, "exact", Z_x, 100.0 * deviation, kind, exact);
      }
    }
  }
}

/// The stiffness of the largest direction that the user feels at X, W Z_q W^T with W = (S J^+)^T,
/// pose by pose; and that of the actuator, which Eq. (9) keeps.
void print_felt(const Device& device) {
  Random random(11);
  std::vector<double> felt;
  for (int i = 0; i < kStates; ++i) {
    const core::Kinematics& map = *device.maps[static_cast<std::size_t>(i) % device.maps.size()];
    const State s = draw(map, 0.0, random);
    const Matrix J_plus = Matrix(s.J).completeOrthogonalDecomposition().pseudoInverse();
    Matrix W(map.space().n_x(), map.layout().n_a());
    for (int a = 0; a < map.layout().n_a(); ++a) {
      const int k = map.layout().actuated(a);
      W.col(a) = J_plus.row(k).transpose() / s.range[k];
    }
    felt.push_back(W.jacobiSvd().singularValues().squaredNorm());
  }
  std::sort(felt.begin(), felt.end());
  const auto at = [&](double share) {
    return felt[static_cast<std::size_t>(share * static_cast<double>(felt.size() - 1))];
  };
  row(device.name, 1.0, at(0.5) / at(0.05), at(0.95) / at(0.05), felt.back() / felt.front());
}

void run(bool felt) {
  if (felt) {
    row("device", "at_the_actuator", "felt_median_over_5pct", "felt_95_over_5pct",
        "felt_largest_over_least");
  } else {
    row("device", "n_a", "n_n", "n_x", "derivative", "Z_x", "deviation_pct", "method", "states",
        "negative_definite_pct", "no_force_from_sensed_pct", "conservative_pct", "curl_median_pct",
        "largest_eigenvalue", "worst_q");
  }
  for (const Device& device : devices()) felt ? print_felt(device) : print_device(device);
}

}  // namespace

void add_claims(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "claims", "What the paper says of the displayed impedance, on six kinds of device");
  command->footer(
      "paper: Eq. (2), (5), (9), J held constant; exact: with dJ/dq, at a proxy that is away by "
      "deviation_pct of every DoF's range. x held, unguarded. conservative: d tau/dq symmetric, so "
      "that no small loop of q does work; curl: its antisymmetric part over the symmetric one, the "
      "median. largest_eigenvalue: of the symmetric part of d tau_a/dq_a over the largest "
      "magnitude; "
      "above 0 the force grows along a motion.");
  auto felt = std::make_shared<bool>(false);
  command->add_flag("--felt", *felt, "spread of the stiffness felt at X over the poses instead");
  command->callback([felt] { run(*felt); });
}

}  // namespace haptic::report
