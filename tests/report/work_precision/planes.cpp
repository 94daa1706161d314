#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "haptic/core/error.hpp"
#include "haptic/core/projection/plane_projection.hpp"
#include "tests/report/work_precision/part.hpp"

namespace haptic::report {
namespace {

using core::VecX;

constexpr int kProbes = 256, kN = 10;  // coordinates of five fingers

/// Probes around random planes that can all be met, for 0 meets them; and the answers of both.
struct Bench {
  core::ConfigurationSpace space;
  core::PlaneProjection projection{space};
  core::PlaneSet planes{};
  std::vector<VecX> probes{}, answers{};

  explicit Bench(int count) : space(coordinates()), projection(space) {
    std::mt19937_64 random(static_cast<unsigned>(count));
    std::normal_distribution<double> normal;
    planes.normals.resize(kN, count);
    planes.offsets.resize(count);
    for (int i = 0; i < count; ++i) {
      for (int k = 0; k < kN; ++k) planes.normals(k, i) = normal(random);
      planes.offsets[i] = std::abs(normal(random));
    }
    projection.set(planes, VecX::Zero(kN));
    while (static_cast<int>(probes.size()) < kProbes) {
      VecX probe(kN);
      for (int k = 0; k < kN; ++k) probe[k] = normal(random);
      if ((planes.normals.transpose() * probe - planes.offsets).maxCoeff() > 0.0) {
        probes.push_back(probe);
      }
    }
    answers.resize(probes.size(), VecX::Zero(kN));
  }
  static std::vector<core::Coordinate> coordinates() {
    std::vector<core::Coordinate> all;
    for (int i = 0; i < kN; ++i) all.push_back({"x" + std::to_string(i), core::Unit::kRadian});
    return all;
  }
};

/// The nearest point that meets every plane: of the subsets of planes taken as equations, the one
/// whose multipliers are not negative and whose point meets the others.
VecX by_enumeration(const core::PlaneSet& planes, const VecX& probe) {
  const int n = planes.size();
  const Eigen::VectorXd r = planes.normals.transpose() * probe - planes.offsets;
  for (unsigned subset = 1; subset < 1u << n; ++subset) {
    Eigen::MatrixXd A(kN, 0);
    Eigen::VectorXd b(0);
    for (int i = 0; i < n; ++i) {
      if ((subset >> i & 1u) == 0) continue;
      A.conservativeResize(Eigen::NoChange, A.cols() + 1);
      A.col(A.cols() - 1) = planes.normals.col(i);
      b.conservativeResize(b.size() + 1);
      b[b.size() - 1] = r[i];
    }
    const Eigen::VectorXd l = (A.transpose() * A).ldlt().solve(b);
    const VecX x = probe - A * l;
    const bool meets = (planes.normals.transpose() * x - planes.offsets).maxCoeff() < 1e-9;
    if (meets && l.minCoeff() >= 0.0) return x;
  }
  throw core::SceneError("work-precision: planes that can be met were not");
}

}  // namespace

std::vector<PartFigure> plane_figures() {
  std::vector<PartFigure> all;
  for (const int count : {1, 3, 6}) {
    const auto bench = std::make_shared<Bench>(count);
    PartFigure figure{"hand", std::to_string(count) + (count == 1 ? " plane" : " planes"),
                      "planes_active_set", "every subset"};
    figure.error_unit = "rad";
    figure.calls = kProbes;
    figure.ours = [bench] {
      for (std::size_t i = 0; i < bench->probes.size(); ++i) {
        static_cast<void>(bench->projection.project(bench->probes[i], bench->answers[i]));
      }
    };
    figure.theirs = [bench] {
      for (const VecX& probe : bench->probes) {
        static_cast<void>(by_enumeration(bench->planes, probe));
      }
    };
    figure.ours();
    double squares = 0.0;
    for (std::size_t i = 0; i < bench->probes.size(); ++i) {
      const VecX exact = by_enumeration(bench->planes, bench->probes[i]);
      const double error = (bench->answers[i] - exact).cwiseAbs().maxCoeff();
      figure.error_max = std::max(figure.error_max, error);
      squares += error * error;
    }
    figure.error_rms = std::sqrt(squares / kProbes);
    all.push_back(std::move(figure));
  }
  return all;
}

}  // namespace haptic::report
