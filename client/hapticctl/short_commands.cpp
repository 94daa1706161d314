// Commands that ask once and print the answer.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "doctor/measure.hpp"
#include "local_control.hpp"

namespace haptic::ctl {

using nlohmann::json;

int health(const Options& options) {
  // A container's health check runs every few seconds; an answer takes a millisecond.
  constexpr std::chrono::milliseconds kPatience{2000};
  const bool serving = connect(options).healthy(options.device, kPatience);
  answer(options, json{{"serving", serving}}.dump(), serving ? "serving" : "not serving");
  return serving ? kDone : kFailed;
}

/// Stops by the host's own socket if there is one: that needs no network, and no network can undo
/// it.
int estop(const Options& options) {
  const std::string device = options.device.empty() ? "" : " " + options.device;
  const auto here = ask_locally(options.server, "stop" + device + "\n" + options.reason);
  const std::vector<std::string> stopped =
      here ? *here : connect(options).emergency_stop(options.device, options.reason);
  answer(options, json{{"stopped", stopped}}.dump(), "stopped: " + joined(stopped));
  return kDone;
}

int clear_fault(const Options& options) {
  std::uint32_t bits = 0;
  for (const std::uint32_t fault : options.faults) bits |= 1U << (fault & 31U);
  const std::string device = options.device.empty() ? "" : " " + options.device;
  const auto here = ask_locally(options.server, "clear" + device + "\n" + std::to_string(bits));
  bits = 0;
  if (here && !here->empty()) bits = static_cast<std::uint32_t>(std::stoul(here->front()));
  if (!here) {
    for (const std::uint32_t fault : connect(options).clear_fault(options.device, options.faults)) {
      bits |= 1U << (fault & 31U);
    }
  }
  const std::vector<std::string> cleared = client::fault_names(bits);
  answer(options, json{{"cleared", cleared}}.dump(), "cleared: " + joined(cleared));
  return kDone;
}

int restart_front(const Options& options) {
  constexpr int kPatienceMs = 30'000;
  std::string refusal;
  if (ask_locally(options.server, "restart-front", &refusal, kPatienceMs)) {
    answer(options, json{{"restarted", true}}.dump(), "a new front serves");
    return kDone;
  }
  if (!refusal.empty()) {
    std::fprintf(stderr, "hapticctl: %s\n", refusal.c_str());
    return kRefused;
  }
  std::fprintf(stderr, "hapticctl: no hapticd on this host serves at %s\n", options.server.c_str());
  return kUnreachable;
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
