#pragma once
/// The paper's measured impedance, Delta tau_a/Delta q_a between samples (section VI.C), with the
/// rule for small denominators of tests/report/STUDY.md#finite-difference-rule-finger_sign_change:
/// a ratio of two small numbers says nothing, so small steps are left out, and how many is reported
/// beside the result.

#include <span>
#include <vector>

namespace haptic::core {

/// A step counts when |dq_a| > max(small_step * rms, 5 sigma_q), rms over all steps.
struct StepRule {
  double small_step{0.1};  ///< share of the rms step
  double sigma_q{0.0};     ///< standard deviation of the sensor's noise, unit of q_a
};

struct FiniteDifferences {
  int steps{0};                    ///< between neighbours that no gap parts
  int kept{0};                     ///< of them, those the rule keeps
  double nonpassive_pct{0.0};      ///< of the kept, with dtau/dq > 0
  double excluded_pct{0.0};        ///< of all steps, left out by the rule
  double all_nonpassive_pct{0.0};  ///< of the steps with dq != 0, with dtau/dq > 0
  /// 100 sum max(0, dtau dq) / sum |dtau dq| over all steps: what no denominator can spoil.
  double energy_weighted_pct{0.0};
  std::vector<double> impedance{};  ///< dtau/dq per step, NaN where left out or across a gap
};

/// `q_a`, `tau_a`: one actuated DoF, sample by sample, equally long. `gap_before[i]` != 0 says that
/// nothing was measured between samples i - 1 and i; empty: no gaps. No step at all gives zeros.
[[nodiscard]] FiniteDifferences finite_differences(std::span<const double> q_a,
                                                   std::span<const double> tau_a,
                                                   const StepRule& rule = {},
                                                   std::span<const char> gap_before = {});

}  // namespace haptic::core
