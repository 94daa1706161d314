#include "tests/report/work_precision/study.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "haptic/core/error.hpp"
#include "haptic/core/model/serial_chain.hpp"
#include "tests/core/model/sample_hands.hpp"
#include "tests/report/values.hpp"

namespace haptic::report {
namespace {

using core::MatXQ;
using core::VecQ;
using core::VecX;

constexpr double kSeconds = 1.0;
constexpr double kInconsistent = 1e-3;  // m

double phase_of(int frame, double rate_hz) {
  return 2.0 * M_PI * frame / (kSeconds * rate_hz);
}

/// (MCP, PIP) of one finger after another, rad; `stopped`: where the stops let them be.
VecX flexion(int fingers, double phase, bool stopped) {
  VecX x(2 * fingers);
  for (int i = 0; i < fingers; ++i) {
    const double at = phase + 0.4 * i;
    x[2 * i] = (30 + 25 * std::sin(at)) * kDegree;
    x[2 * i + 1] = (35 + 30 * std::sin(at + 0.3)) * kDegree;
    if (!stopped) continue;
    x[2 * i] = std::min(x[2 * i], 25 * kDegree);
    x[2 * i + 1] = std::min(x[2 * i + 1], 30 * kDegree);
  }
  return x;
}

VecQ inverse(const core::Kinematics& map, const VecX& x) {
  VecQ q;
  if (map.inverse(x, q) != core::InverseStatus::kExact) {
    throw core::SceneError("work-precision: a pose of the motion is out of reach");
  }
  return q;
}

VecX image(const core::Kinematics& map, const VecQ& q) {
  VecX x;
  if (map.position(q, x) != core::MapStatus::kOk) {
    throw core::SceneError("work-precision: a pose of the motion has no image");
  }
  return x;
}

/// The residual at an optimum is orthogonal to every column of J: at most 1e-12 of X's unit along any.
void require_stationary(const core::Kinematics& map, const VecX& x, const VecQ& q) {
  constexpr double kLeft = 1e-12;
  VecX at, r;
  MatXQ J;
  static_cast<void>(map.evaluate(q, at, J));
  map.space().difference(x, at, r);
  for (Eigen::Index k = 0; k < J.cols(); ++k) {
    const double along = std::abs(J.col(k).dot(r)) / J.col(k).norm();
    if (!(along <= kLeft)) {
      throw core::SceneError("work-precision: a reference leaves " + std::to_string(along * 1e12) +
                             "e-12 along column " + std::to_string(k) + ", at most 1e-12 allowed");
    }
  }
}

/// Gauss-Newton by Eigen's rank-revealing QR, from the pose that the proxy was made of. Independent of
/// every solver that is measured.
VecQ converged(const core::Kinematics& map, const VecX& x, VecQ q) {
  constexpr int kMost = 200;
  VecX at, r;
  MatXQ J;
  double step = HUGE_VAL;
  for (int n = 0; n < kMost && step > 1e-13; ++n) {
    if (map.evaluate(q, at, J) != core::MapStatus::kOk) break;
    map.space().difference(x, at, r);
    const Eigen::VectorXd dq = Eigen::MatrixXd(J).colPivHouseholderQr().solve(Eigen::VectorXd(r));
    q += dq;
    step = 0.0;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const core::DofSpec& dof = map.dofs()[static_cast<std::size_t>(i)];
      step = std::max(step, std::abs(dq[i]) / (dof.upper - dof.lower));
      if (!(q[i] > dof.lower && q[i] < dof.upper)) step = HUGE_VAL;  // peers know no box
    }
  }
  if (!(step <= 1e-12)) throw core::SceneError("work-precision: a reference did not converge");
  require_stationary(map, x, q);
  return q;
}

void add_frame(Study& study, const VecQ& q, const VecQ& held, double phase, double inconsistent) {
  VecX x = image(*study.kinematics, held);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    x[i] += inconsistent * std::sin(phase + 1.7 * static_cast<double>(i));
  }
  study.q.push_back(q);
  study.q_star.push_back(converged(*study.kinematics, x, held));
  study.x.push_back(x);
}

Study exoskeleton_study(std::string name, std::shared_ptr<const core::Kinematics> map,
                        double rate_hz) {
  Study study{std::move(name), "m", std::move(map)};
  const int fingers = study.kinematics->layout().n_a();
  for (int k = 0; k < static_cast<int>(kSeconds * rate_hz); ++k) {
    const double phase = phase_of(k, rate_hz);
    add_frame(study, inverse(*study.kinematics, flexion(fingers, phase, false)),
              inverse(*study.kinematics, flexion(fingers, phase, true)), phase, 0.0);
  }
  return study;
}

std::shared_ptr<const core::Kinematics> arm() {
  using core::JointKind, core::OutputKind;
  core::SerialChainParameters chain;
  const core::Point3 axes[] = {{0, 0, 1}, {0, 1, 0}, {0, 1, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}};
  const double along[] = {0.0, 0.0, 0.10, 0.08, 0.04, 0.03};  // m, from joint to joint
  for (int i = 0; i < 6; ++i) {
    chain.joints.push_back({"joint" + std::to_string(i + 1),
                            JointKind::kRevolute,
                            i < 4,
                            "",
                            {{along[i], 0, 0}, {}},
                            axes[i],
                            -2.5,
                            2.5});
  }
  chain.outputs = {{"elbow", "joint3", OutputKind::kPoint, {{0.06, 0.0, 0.03}, {}}},
                   {"wrist", "joint5", OutputKind::kPoint, {{0.02, 0.03, 0.0}, {}}},
                   {"tip", "joint6", OutputKind::kPoint, {{0.04, 0.0, 0.04}, {}}}};
  return core::make_serial_chain(chain);
}

}  // namespace

Study finger_study(double rate_hz) {
  return exoskeleton_study("finger", core::make_finger_exoskeleton({}), rate_hz);
}

Study hand_study(double rate_hz) {
  return exoskeleton_study("hand", core::make_hand_exoskeleton(core::five_fingers()), rate_hz);
}

Study tracked_hand_study(double rate_hz) {
  Study study{"tracked_hand", "m", core::make_tracked_hand(core::five_fingers_on_a_palm())};
  const auto fingers = core::make_hand_exoskeleton(core::five_fingers());
  for (int k = 0; k < static_cast<int>(kSeconds * rate_hz); ++k) {
    const double phase = phase_of(k, rate_hz);
    VecQ q(16), held(16);
    q << 0.05 * std::sin(phase), 0.04 * std::cos(phase), 0.03 * std::sin(2 * phase),
        0.3 * std::sin(phase), 0.2 * std::cos(phase), 0.25 * std::sin(phase + 1.0),
        inverse(*fingers, flexion(5, phase, false));
    held << q.head(6), inverse(*fingers, flexion(5, phase, true));
    add_frame(study, q, held, phase, kInconsistent);
  }
  return study;
}

Study chain_study(double rate_hz) {
  Study study{"chain", "rad", arm()};
  for (int k = 0; k < static_cast<int>(kSeconds * rate_hz); ++k) {
    const double phase = phase_of(k, rate_hz);
    VecQ q(6), held(6);
    for (int i = 0; i < 6; ++i) {
      q[i] = 1.0 + 0.35 * std::sin(phase + 0.7 * i);  // no two axes near a line
      held[i] = std::min(q[i], 1.1);
    }
    add_frame(study, q, held, phase, kInconsistent);
  }
  return study;
}

}  // namespace haptic::report
