#include "tests/report/analysis/vibration.hpp"

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace haptic::report {

double vibration_threshold(double hz) noexcept {
  constexpr double kLeast = 1e-7, kFrom = 250.0, kTo = 300.0;
  const double off = hz < kFrom ? kFrom / hz : hz > kTo ? hz / kTo : 1.0;
  return kLeast * off * off;
}

double tip_compliance(const hw::FingerParameters& finger, const Eigen::Vector2d& x,
                      const Eigen::Vector2d& w, double hz) noexcept {
  using Complex = std::complex<double>;
  constexpr double kProximal = 0.045, kDistal = 0.040;  // m, as the soft finger's
  const double omega = 2.0 * std::numbers::pi * hz;
  const Eigen::Matrix2d ww = w * w.transpose();
  Eigen::Matrix2d inertia = finger.actuator_mass * ww, damping = finger.actuator_damping * ww;
  inertia.diagonal() += finger.inertia;
  damping.diagonal().array() += finger.hand_damping;
  Eigen::Matrix2cd stiffness = (-omega * omega * inertia).cast<Complex>();
  stiffness += Complex(0.0, omega) * damping.cast<Complex>();
  stiffness.diagonal().array() += finger.hand_stiffness;
  const Eigen::Vector2cd angles = stiffness.inverse() * w.cast<Complex>();
  const double a = x[0] + x[1];
  Eigen::Matrix2d tip;  // of the way per rad of MCP and PIP
  tip.col(1) = kDistal * Eigen::Vector2d(-std::sin(a), -std::cos(a));
  tip.col(0) = tip.col(1) + kProximal * Eigen::Vector2d(-std::sin(x[0]), -std::cos(x[0]));
  return (tip.cast<Complex>() * angles).norm();
}

double band_rms(std::span<const double> samples, const std::function<double(double)>& weight) {
  constexpr double kSamples_hz = 1000.0;
  const std::size_t n = samples.size();
  const double mean = std::accumulate(samples.begin(), samples.end(), 0.0) / static_cast<double>(n);
  std::vector<double> windowed(n);
  double power = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double phase = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
    const double window = 0.5 - 0.5 * std::cos(phase);
    windowed[i] = window * (samples[i] - mean);
    power += window * window;
  }
  std::vector<std::complex<double>> spectrum;
  Eigen::FFT<double>().fwd(spectrum, windowed);
  double sum = 0.0;
  for (std::size_t k = 1; 2 * k <= n; ++k) {
    const double hz = kSamples_hz * static_cast<double>(k) / static_cast<double>(n);
    if (hz < kLowest_hz || hz > kHighest_hz) continue;
    const double sides = 2 * k == n ? 1.0 : 2.0, part = weight(hz);
    sum += sides * part * part * std::norm(spectrum[k]);
  }
  return std::sqrt(sum / (power * static_cast<double>(n)));
}

double run_band_rms(std::span<const double> samples) {
  constexpr std::size_t kSegment = 256;
  double sum = 0.0;
  int segments = 0;
  for (std::size_t from = 0; from + kSegment <= samples.size(); from += kSegment / 2) {
    const double one = band_rms(samples.subspan(from, kSegment));
    sum += one * one;
    ++segments;
  }
  return segments > 0 ? std::sqrt(sum / segments) : 0.0;
}

}  // namespace haptic::report
