#include <algorithm>
#include <cmath>
#include <memory>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/projection/monotone_envelope.hpp"
#include "tests/report/values.hpp"
#include "tests/report/work_precision/part.hpp"
#include "tests/report/work_precision/study.hpp"

namespace haptic::report {
namespace {

using core::MatXQ;
using core::VecQ;
using core::VecX;

constexpr int kSamples = 400;
constexpr int kPoses = 240;

/// The corner of core/METHOD.md#forces-at-the-finger: the MCP stopped at 18 degrees, the PIP free and
/// far, where (6) alone pulls into the stop.
Study pressed_at_the_mcp() {
  Study study{"finger", "m", core::make_finger_exoskeleton({})};
  for (int k = 0; k < kPoses; ++k) {
    const double depth = (k + 0.5) / kPoses;
    const VecX at =
        (VecX(2) << (18 + 32 * depth) * kDegree, (40 + 30 * depth) * kDegree).finished();
    VecQ q;
    if (study.kinematics->inverse(at, q) != core::InverseStatus::kExact) {
      throw core::SceneError("work-precision: a pose of the press is out of reach");
    }
    study.q.push_back(q);
    study.x.push_back((VecX(2) << 18 * kDegree, at[1]).finished());
  }
  return study;
}

struct Bench {
  Study study = pressed_at_the_mcp();
  core::MonotoneEnvelope envelope{core::ProjectionModel(*study.kinematics)};
  std::vector<double> answers{};  ///< dq_a, m

  void ours() {
    VecX at, dx;
    MatXQ J;
    core::Projection out;
    for (std::size_t i = 0; i < study.q.size(); ++i) {
      const VecQ& q = study.q[i];
      static_cast<void>(study.kinematics->evaluate(q, at, J));
      study.kinematics->space().difference(study.x[i], at, dx);
      static_cast<void>(study.kinematics->inverse(study.x[i], out.q_star));
      const core::EnvelopeAnswer answer =
          envelope.apply({q, at, J}, dx, core::RendererKind::kSubspaceExact, out);
      const bool withheld = answer == core::EnvelopeAnswer::kWithheld;
      answers[i] = withheld ? 0.0 : out.q_star[0] - q[0];
    }
  }
  /// dq_a: the largest of the right sign along x_probe + s dx, s = 1/400 .. 1, by the closed form.
  [[nodiscard]] double sampled(std::size_t i) const {
    const VecQ& q = study.q[i];
    VecX at;
    MatXQ J;
    static_cast<void>(study.kinematics->evaluate(q, at, J));
    const VecX dx = study.x[i] - at;
    // S J^-1 dx of a 2 x 2 J, by Cramer's rule.
    const double det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
    const double towards = (dx[0] * J(1, 1) - dx[1] * J(0, 1)) / det < 0.0 ? -1.0 : 1.0;
    double most = 0.0;
    VecQ q_star;
    for (int k = 1; k <= kSamples; ++k) {
      const VecX x = at + (static_cast<double>(k) / kSamples) * dx;
      if (study.kinematics->inverse(x, q_star) != core::InverseStatus::kExact) break;
      most = std::max(most, towards * (q_star[0] - q[0]));
    }
    return towards * most;
  }
};

}  // namespace

std::vector<PartFigure> envelope_figures() {
  const auto bench = std::make_shared<Bench>();
  bench->answers.resize(bench->study.q.size());
  PartFigure figure{"finger", "MCP stop", "monotone_envelope", "400 points"};
  figure.error_unit = "m";
  figure.calls = static_cast<int>(bench->study.q.size());
  figure.ours = [bench] { bench->ours(); };
  figure.theirs = [bench] {
    for (std::size_t i = 0; i < bench->answers.size(); ++i) bench->answers[i] = bench->sampled(i);
  };
  figure.ours();
  double squares = 0.0;
  for (std::size_t i = 0; i < bench->answers.size(); ++i) {
    const double error = std::abs(bench->answers[i] - bench->sampled(i));
    figure.error_max = std::max(figure.error_max, error);
    squares += error * error;
  }
  figure.error_rms = std::sqrt(squares / static_cast<double>(bench->answers.size()));
  return {figure};
}

}  // namespace haptic::report
