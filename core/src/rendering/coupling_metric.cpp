#include "haptic/core/rendering/coupling_metric.hpp"

#include <cmath>

#include "haptic/core/linear/full_column_rank.hpp"

namespace haptic::core {

namespace {

/// W_x^{1/2}, n_x by n_x.
Eigen::MatrixXd root_of(const TaskMetric& W_x, int n_x) {
  Eigen::MatrixXd root(n_x, n_x);
  for (int j = 0; j < n_x; ++j) {
    VecX column = VecX::Unit(n_x, j);
    W_x.weigh(column);
    root.col(j) = column;
  }
  return root;
}

}  // namespace

std::optional<Eigen::MatrixXd> coupling_metric(const Kinematics& map, const TaskMetric& W_x,
                                               const VecQ& q, const VecA& stiffness,
                                               double softness, const StiffnessCoupling* coupling) {
  const DofLayout& layout = map.layout();
  VecX x_probe;
  MatXQ A;
  if (q.size() != layout.n_q() || stiffness.size() != layout.n_a()) return std::nullopt;
  if (!(stiffness.minCoeff() > 0.0)) return std::nullopt;
  if (map.evaluate(q, x_probe, A) != MapStatus::kOk) return std::nullopt;
  W_x.weigh(A);
  if (!A.allFinite()) return std::nullopt;
  const std::optional<FullColumnRank> rank = full_column_rank(A);
  if (!rank) return std::nullopt;

  double k_x = 0.0;
  for (int i = 0; i < layout.n_a(); ++i) {
    k_x += stiffness[i] / A.col(layout.actuated(i)).squaredNorm();
  }
  k_x *= softness / layout.n_a();
  Eigen::VectorXd weight(layout.n_q());
  for (int i = 0; i < layout.n_a(); ++i) weight[layout.actuated(i)] = stiffness[i];
  for (int i = 0; i < layout.n_n(); ++i) {
    weight[layout.sensed(i)] = k_x * A.col(layout.sensed(i)).squaredNorm();
  }
  const Eigen::MatrixXd root = root_of(W_x, static_cast<int>(A.rows()));
  const Eigen::MatrixXd to_q = rank->inverse * root;  // dx -> dq
  Eigen::MatrixXd M = weight.asDiagonal();
  if (coupling != nullptr) {
    const MatAA Z_q = coupling->matrix(stiffness);
    for (int i = 0; i < layout.n_a(); ++i) {
      for (int j = 0; j < layout.n_a(); ++j) M(layout.actuated(i), layout.actuated(j)) = Z_q(i, j);
    }
  }
  Eigen::MatrixXd W = to_q.transpose() * M * to_q;
  if (A.rows() > A.cols()) {
    const Eigen::MatrixXd rest = rank->off * root;
    W += k_x * (rest.transpose() * rest);
  }
  if (!W.allFinite()) return std::nullopt;
  return Eigen::MatrixXd(0.5 * (W + W.transpose()));
}

std::vector<CouplingBlock> coupling_blocks(const ProjectionModel& model, const VecQ& q,
                                           const VecA& stiffness, double softness) {
  std::vector<CouplingBlock> answer;
  for (const MapBlock& block : model.blocks()) {
    const int n_q = block.n_q(), n_a = block.n_a(), n_x = block.n_x();
    CouplingBlock entry{n_x, {}};
    const bool known = q.size() >= block.first_q + n_q && stiffness.size() >= block.first_a + n_a;
    const auto W = known ? coupling_metric(*block.kinematics, model.metric().of(block.first_x, n_x),
                                           q.segment(block.first_q, n_q),
                                           stiffness.segment(block.first_a, n_a), softness,
                                           model.coupling().get())
                         : std::nullopt;
    for (int i = 0; W && i < n_x; ++i) {
      for (int j = 0; j <= i; ++j) entry.lower.push_back((*W)(i, j));
    }
    answer.push_back(std::move(entry));
  }
  return answer;
}

}  // namespace haptic::core
