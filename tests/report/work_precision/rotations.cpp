#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "haptic/core/model/configuration_space.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/work_precision/part.hpp"

namespace haptic::report {
namespace {

using core::VecX;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr int kPairs = 256;

/// Pairs of rotations `angle` apart, as X holds them, and the lengths that the methods find.
struct Bench {
  core::ConfigurationSpace space{{{"qx", core::Unit::kRadian, core::CoordinateKind::kQuaternion},
                                  {"qy", core::Unit::kRadian, core::CoordinateKind::kQuaternion},
                                  {"qz", core::Unit::kRadian, core::CoordinateKind::kQuaternion},
                                  {"qw", core::Unit::kRadian, core::CoordinateKind::kQuaternion}}};
  std::vector<VecX> from{}, to{};
  std::vector<double> angles{};
  double angle;

  explicit Bench(double theta) : angles(kPairs), angle(theta) {
    std::mt19937_64 random(8);
    std::normal_distribution<double> normal;
    for (int i = 0; i < kPairs; ++i) {
      const Vector3d axis = Vector3d(normal(random), normal(random), normal(random)).normalized();
      const Quaterniond a =
          Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
      from.emplace_back(a.coeffs());
      to.emplace_back((Quaterniond(Eigen::AngleAxisd(theta, axis)) * a).coeffs());
    }
  }
  [[nodiscard]] Quaterniond error(std::size_t i) const {
    const Eigen::Vector4d before = from[i], after = to[i];
    const Quaterniond a(before), b(after);
    return b * a.conjugate();
  }
  void chord_of_x() {
    VecX dx;
    for (std::size_t i = 0; i < from.size(); ++i) {
      space.difference(to[i], from[i], dx);
      angles[i] = 2.0 * dx.norm();  // half radians
    }
  }
  void half_angle_chord() {
    for (std::size_t i = 0; i < from.size(); ++i) {
      const Quaterniond e = error(i);
      const Vector3d r = (e.w() < 0.0 ? -2.0 : 2.0) * e.vec();
      angles[i] = r.norm();
    }
  }
  void logarithm() {
    for (std::size_t i = 0; i < from.size(); ++i) {
      const Quaterniond e = error(i);
      const double sine = e.vec().norm(), sign = e.w() < 0.0 ? -1.0 : 1.0;
      const double theta = 2.0 * std::atan2(sine, sign * e.w());
      const Vector3d r =
          sine > 1e-12 ? Vector3d(sign * theta / sine * e.vec()) : Vector3d(2.0 * sign * e.vec());
      angles[i] = r.norm();
    }
  }
};

}  // namespace

std::vector<PartFigure> rotation_figures() {
  std::vector<PartFigure> all;
  for (const double theta : {0.1, 0.5, 1.0, 2.0, 3.0}) {
    const auto bench = std::make_shared<Bench>(theta);
    const auto add = [&](const char* method, void (Bench::*run)()) {
      PartFigure figure{"rotation", cell(theta) + " rad", method, "logarithm"};
      figure.error_unit = "relative";
      figure.calls = kPairs;
      figure.ours = [bench, run] { (bench.get()->*run)(); };
      figure.theirs = [bench] { bench->logarithm(); };
      figure.ours();
      double squares = 0.0;
      for (const double found : bench->angles) {
        const double error = std::abs(found - theta) / theta;
        figure.error_max = std::max(figure.error_max, error);
        squares += error * error;
      }
      figure.error_rms = std::sqrt(squares / kPairs);
      all.push_back(std::move(figure));
    };
    add("chord_4sin_quarter", &Bench::chord_of_x);
    add("chord_2sin_half", &Bench::half_angle_chord);
    add("logarithm", &Bench::logarithm);
  }
  return all;
}

}  // namespace haptic::report
