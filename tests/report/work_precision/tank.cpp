#include <algorithm>
#include <cmath>
#include <memory>

#include "haptic/core/projection/block_renderer.hpp"
#include "tests/report/work_precision/part.hpp"
#include "tests/report/work_precision/study.hpp"
#include "tests/support/dense_oracle.hpp"

namespace haptic::report {
namespace {

using core::MatXQ;
using core::VecA;
using core::VecX;

constexpr double kStiffness = 1500.0;  // N/m of every actuator

/// Frames of a study, f and J in place: what a tick has when it books the tank's spring.
struct Bench {
  Study study;
  core::ProjectionModel model;
  core::BlockRenderer renderer;
  VecA Z_q, ratio;
  std::vector<VecX> x_probe{}, dx{};
  std::vector<MatXQ> J{};
  std::vector<VecA> answers{};

  explicit Bench(Study of)
      : study(std::move(of)),
        model(*study.kinematics),
        renderer(core::RendererKind::kStandard, model),
        Z_q(VecA::Constant(model.layout().n_a(), kStiffness)),
        answers(study.q.size(), Z_q) {
    for (std::size_t i = 0; i < study.q.size(); ++i) {
      VecX at, away;
      MatXQ slope;
      static_cast<void>(study.kinematics->evaluate(study.q[i], at, slope));
      study.kinematics->space().difference(study.x[i], at, away);
      x_probe.push_back(at);
      dx.push_back(away);
      J.push_back(slope);
    }
  }
  void ours() {
    for (std::size_t i = 0; i < J.size(); ++i) {
      renderer.displayed_bound({study.q[i], x_probe[i], J[i]}, dx[i], Z_q, answers[i]);
    }
  }
  /// The largest eigenvalue of Z_q^-1/2 J_a^T Z_x J_a Z_q^-1/2 of the block of actuator `a`, one of
  /// blocks with one actuator each; at least 1, and 1 where the block's proxy is its probe.
  [[nodiscard]] double by_eigenvalue(std::size_t i, int a) const {
    const auto& blocks = study.kinematics->blocks();
    const core::Kinematics& part = blocks.empty() ? *study.kinematics : *blocks[a].kinematics;
    const int row = blocks.empty() ? 0 : blocks[a].first_x, n_x = part.space().n_x();
    const int column = (blocks.empty() ? 0 : blocks[a].first_q) + part.layout().actuated(0);
    if ((dx[i].segment(row, n_x).array() == 0.0).all()) return 1.0;
    const double mean = part.mean_actuated_jacobian();
    const Eigen::MatrixXd J_a = J[i].block(row, column, n_x, 1) / mean;
    const Eigen::VectorXd all = oracle::singular_values(J_a);
    return std::max(1.0, all[0] * all[0]);
  }
  void theirs() {
    for (std::size_t i = 0; i < J.size(); ++i) {
      for (int a = 0; a < model.layout().n_a(); ++a) answers[i][a] = by_eigenvalue(i, a);
    }
  }
};

PartFigure figure_of(Study study) {
  PartFigure figure{study.map, "Eq. (1)", "tank_displayed_bound", "largest eigenvalue"};
  const auto bench = std::make_shared<Bench>(std::move(study));
  figure.error_unit = "relative";
  figure.calls = static_cast<int>(bench->J.size());
  figure.ours = [bench] { bench->ours(); };
  figure.theirs = [bench] { bench->theirs(); };
  figure.ours();
  double squares = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < bench->J.size(); ++i) {
    for (int a = 0; a < bench->model.layout().n_a(); ++a, ++count) {
      const double exact = bench->by_eigenvalue(i, a);
      const double error = std::abs(bench->answers[i][a] - exact) / exact;
      figure.error_max = std::max(figure.error_max, error);
      squares += error * error;
    }
  }
  figure.error_rms = std::sqrt(squares / std::max(count, 1));
  return figure;
}

}  // namespace

std::vector<PartFigure> tank_figures() {
  constexpr double kFrames = 1000.0;  // Hz
  std::vector<PartFigure> all;
  all.push_back(figure_of(finger_study(kFrames)));
  all.push_back(figure_of(hand_study(kFrames)));
  return all;
}

}  // namespace haptic::report
