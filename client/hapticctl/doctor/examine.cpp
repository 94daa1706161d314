#include "doctor/examine.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "doctor/checks.hpp"

namespace haptic::ctl {
namespace {

// In the order of Health.
constexpr const char* kWords[] = {"good", "impaired", "bad"};
constexpr const char* kGrades[] = {"real-time", "degraded", "unfit"};

const char* word(const Finding& finding) {
  return kWords[static_cast<std::size_t>(finding.health)];
}

/// core/METHOD.md#sampled-data. A force that is held gives out energy in proportion to the time for
/// which it was held, so the longest time limits passivity; the usual delay limits stability.
StiffnessCap cap_of(const HostFiles& host, const Jitter& jitter,
                    const StiffnessQuestion& question) {
  StiffnessCap cap;
  cap.hold_s = question.period_s + 1e-6 * jitter.max_us;
  cap.delay_s = 1e-6 * jitter.p99_us + serial_latency(host);
  cap.passive =
      std::max(0.0, 2.0 * (question.device_damping - question.rendered_damping)) / cap.hold_s;
  cap.stable = (question.device_damping + question.rendered_damping) /
               (0.5 * question.period_s + cap.delay_s);
  return cap;
}

}  // namespace

Report examine(const HostFiles& host, const HostAnswers& answers,
               const StiffnessQuestion& question) {
  Report report;
  report.findings = {check_kernel(host),
                     check_realtime(answers),
                     check_memory(answers),
                     check_idle(answers),
                     check_cgroup(host),
                     check_governor(host),
                     check_jitter(answers.jitter, question.period_s)};
  for (Finding& port : check_serial(host, answers)) report.findings.push_back(std::move(port));
  Health worst = Health::kGood;
  for (const Finding& finding : report.findings) worst = std::max(worst, finding.health);
  report.grade = kGrades[static_cast<std::size_t>(worst)];
  report.cap = cap_of(host, answers.jitter, question);
  return report;
}

std::string to_text(const Report& report, const StiffnessQuestion& question) {
  std::string text;
  for (const Finding& finding : report.findings) {
    char row[512];
    std::snprintf(row, sizeof row, "%-10s %-9s %s\n", finding.what.c_str(), word(finding),
                  finding.found.c_str());
    text += row;
    if (!finding.advice.empty()) text += std::string(21, ' ') + "-> " + finding.advice + "\n";
  }
  char rest[512];
  std::snprintf(rest, sizeof rest,
                "\ngrade: %s\nstiffness for b = %g N s/m, B = %g N s/m at %g ms: up to %.0f N/m "
                "passive, up to %.0f N/m stable\n"
                "(a force was held for up to %.3f ms; %.3f ms of delay)\n",
                report.grade.c_str(), question.device_damping, question.rendered_damping,
                1e3 * question.period_s, report.cap.passive, report.cap.stable,
                1e3 * report.cap.hold_s, 1e3 * report.cap.delay_s);
  return text + rest;
}

std::string to_json(const Report& report, const StiffnessQuestion& question) {
  nlohmann::json findings = nlohmann::json::array();
  for (const Finding& finding : report.findings) {
    findings.push_back({{"what", finding.what},
                        {"health", word(finding)},
                        {"found", finding.found},
                        {"advice", finding.advice}});
  }
  return nlohmann::json({{"grade", report.grade},
                         {"findings", findings},
                         {"stiffness_cap",
                          {{"device_damping_n_s_per_m", question.device_damping},
                           {"rendered_damping_n_s_per_m", question.rendered_damping},
                           {"period_ms", 1e3 * question.period_s},
                           {"hold_ms", 1e3 * report.cap.hold_s},
                           {"delay_ms", 1e3 * report.cap.delay_s},
                           {"passive_n_per_m", report.cap.passive},
                           {"stable_n_per_m", report.cap.stable}}}})
      .dump();
}

}  // namespace haptic::ctl
