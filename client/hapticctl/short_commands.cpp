// Commands that ask once and print the answer.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "doctor/measure.hpp"

namespace haptic::ctl {

using nlohmann::json;

int health(const Options& options) {
  // A container's health check runs every few seconds; an answer takes a millisecond.
  constexpr std::chrono::milliseconds kPatience{2000};
  const bool serving = connect(options).healthy(options.device, kPatience);
  answer(options, json{{"serving", serving}}.dump(), serving ? "serving" : "not serving");
  return serving ? kDone : kFailed;
}

int estop(const Options& options) {
  const auto stopped = connect(options).emergency_stop(options.device, options.reason);
  answer(options, json{{"stopped", stopped}}.dump(), "stopped: " + joined(stopped));
  return kDone;
}

int clear_fault(const Options& options) {
  std::uint32_t bits = 0;
  for (const std::uint32_t fault : connect(options).clear_fault(options.device, options.faults)) {
    bits |= 1U << (fault & 31U);
  }
  const std::vector<std::string> cleared = client::fault_names(bits);
  answer(options, json{{"cleared", cleared}}.dump(), "cleared: " + joined(cleared));
  return kDone;
}

/// Examines the host that it runs on; needs no server.
int doctor(const Options& options) {
  StiffnessQuestion question;
  question.device_damping = options.device_damping;
  question.rendered_damping = options.damping;
  constexpr double kSeconds = 10.0;
  const double seconds = options.seconds > 0.0 ? options.seconds : kSeconds;
  if (!options.json) std::fprintf(stderr, "measuring %g s of a bare 1 kHz loop ...\n", seconds);
  const Report report = examine(HostFiles(), ask_host(seconds, question.period_s), question);
  answer(options, to_json(report, question), to_text(report, question));
  return report.grade == "unfit" ? kFailed : kDone;
}

}  // namespace haptic::ctl
