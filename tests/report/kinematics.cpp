/// haptic-report kinematics: one pose of the finger exoskeleton (core/METHOD.md#finger-linkage),
/// from q or from x.
#include <Eigen/SVD>
#include <limits>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/values.hpp"

namespace haptic::report {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

struct Answer {
  core::VecQ q{};
  core::VecX x{core::VecX::Constant(2, kNone)};
  core::MatXQ J{core::MatXQ::Constant(2, 2, kNone)};
  core::FingerPose inner{};
  double residual{kNone};
  const char* status{"cannot_close"};
};

/// f, J and the sliders at answer.q; false where the linkage has no configuration there.
bool evaluate(const core::Kinematics& finger, Answer& answer) {
  if (finger.evaluate(answer.q, answer.x, answer.J) != core::MapStatus::kOk) return false;
  answer.inner = core::finger_pose({}, answer.q[0], answer.q[1]);
  return true;
}

Answer at_q(const core::Kinematics& finger, const Pair& q) {
  Answer answer;
  answer.q = (core::VecQ(2) << q.first, q.second).finished();
  if (!evaluate(finger, answer)) return answer;
  core::VecQ nearest(2);
  const core::InverseStatus found = finger.inverse(answer.x, nearest);
  core::VecX there;
  core::MatXQ J;
  if (finger.evaluate(nearest, there, J) == core::MapStatus::kOk) {
    answer.residual = (answer.x - there).norm();
  }
  answer.status = found == core::InverseStatus::kExact ? "exact" : "unreachable";
  return answer;
}

Answer at_x(const core::Kinematics& finger, const Pair& x) {
  Answer answer;
  const core::VecX wanted = (core::VecX(2) << x.first, x.second).finished();
  answer.q = core::VecQ::Zero(2);
  const core::InverseStatus found = finger.inverse(wanted, answer.q);
  if (!evaluate(finger, answer)) return answer;
  answer.residual = (wanted - answer.x).norm();
  answer.status = found == core::InverseStatus::kExact ? "exact" : "unreachable";
  return answer;
}

void print(const Answer& answer) {
  const bool closes = answer.inner.status == core::MapStatus::kOk;
  double cond = kNone;
  if (closes) {
    const Eigen::Matrix2d J = answer.J;
    const Eigen::Vector2d s = Eigen::JacobiSVD<Eigen::Matrix2d>(J).singularValues();
    cond = s[0] / s[1];
  }
  row("name", "value");
  row("l_x_m", answer.q[0]);
  row("q_B_rad", answer.q[1]);
  row("q_o1_mcp_rad", answer.x[0]);
  row("q_o2_pip_rad", answer.x[1]);
  row("c1_m", closes ? answer.inner.c1 : kNone);
  row("c2_m", closes ? answer.inner.c2 : kNone);
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 2; ++k) {
      row("J" + std::to_string(i + 1) + std::to_string(k + 1), answer.J(i, k));
    }
  }
  row("cond", cond);
  row("residual_rad", answer.residual);
  row("status", answer.status);
}

}  // namespace

void add_kinematics(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("kinematics", "One pose of the finger exoskeleton: name,value");
  command->footer(
      "J is d(MCP, PIP)/d(l_x, q_B) in rad/m and rad/rad, cond its 2-norm condition number in "
      "these "
      "units.\nresidual_rad: distance in joint space to the nearest pose that the box and the "
      "sliders allow.\nstatus: exact; unreachable (--x: the nearest pose in reach is shown; --q: "
      "the pose lies beyond the limits); cannot_close.");
  auto q = std::make_shared<Pair>();
  auto x = std::make_shared<Pair>();
  CLI::Option_group* which = command->add_option_group("pose");
  CLI::Option* by_q = which->add_option("--q", *q, "actuator and linkage: L_M,QB_RAD");
  which->add_option("--x", *x, "finger joints: MCP_RAD,PIP_RAD");
  which->require_option(1);
  command->callback([q, x, by_q] {
    const auto finger = core::make_finger_exoskeleton({});
    print(by_q->count() > 0 ? at_q(*finger, *q) : at_x(*finger, *x));
  });
}

}  // namespace haptic::report
