// Commands that ask once and print the answer.
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "commands.hpp"
#include "doctor/measure.hpp"
#include "front_claims.hpp"
#include "local_control.hpp"
#include "say.hpp"

namespace haptic::ctl {

using nlohmann::json;

namespace {

std::string content(const char* file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// The answer of this host's control socket; absent: there is none.
std::optional<FrontClaims> claims_here(const std::string& server) {
  const auto lines = ask_locally(server, "health");
  if (!lines) return std::nullopt;
  FrontClaims claims = front_claims(*lines);
  const std::string local = content("/proc/net/unix");
  if (local.empty()) return claims;
  claims.connections = count_connections(
      claims.addresses, content("/proc/net/tcp") + content("/proc/net/tcp6"), local);
  return claims;
}

}  // namespace

/// On the server's host also what the owner of the devices says, which the front cannot change.
int health(const Options& options) {
  // A container's health check runs every few seconds; an answer takes a millisecond.
  constexpr std::chrono::milliseconds kPatience{2000};
  const auto claims = claims_here(options.server);
  bool serving = false;
  try {
    serving = connect(options).healthy(options.device, kPatience);
  } catch (const client::ClientError& error) {
    const bool silent = error.reason() == client::ErrorReason::kUnreachable ||
                        error.reason() == client::ErrorReason::kTimeout;
    if (!silent || !claims) throw;
  }
  json all{{"serving", serving}};
  if (claims) all["front"] = to_json(*claims);
  if (options.json) {
    say("%s\n", dump(all));
  } else {
    say("%s\n", serving ? "serving" : "not serving");
    if (claims) say("%s\n", to_text(*claims).c_str());  // printable, and of several lines
  }
  return serving ? kDone : kFailed;
}

/// Stops by the host's own socket if there is one: that needs no network, and no network can undo
/// it.
int estop(const Options& options) {
  const std::string device = options.device.empty() ? "" : " " + options.device;
  const auto here = ask_locally(options.server, "stop" + device + "\n" + options.reason);
  const std::vector<std::string> stopped =
      here ? *here : connect(options).emergency_stop(options.device, options.reason);
  answer(options, dump(json{{"stopped", stopped}, {"locally", here.has_value()}}),
         "stopped " + std::string(here ? "locally" : "over the network") + ": " + joined(stopped) +
             (here ? "; cleared only on this host"
                   : "; every client that may control it may clear it"));
  return kDone;
}

int clear_fault(const Options& options) {
  std::uint32_t bits = 0;
  for (const std::uint32_t fault : options.faults) bits |= 1U << (fault & 31U);
  const std::string device = options.device.empty() ? "" : " " + options.device;
  const auto here = ask_locally(options.server, "clear" + device + "\n" + std::to_string(bits));
  bits = 0;
  if (here && !here->empty()) {
    bits = static_cast<std::uint32_t>(std::strtoul(here->front().c_str(), nullptr, 10));
  }
  if (!here) {
    for (const std::uint32_t fault : connect(options).clear_fault(options.device, options.faults)) {
      bits |= 1U << (fault & 31U);
    }
  }
  const std::vector<std::string> cleared = client::fault_names(bits);
  answer(options, dump(json{{"cleared", cleared}}), "cleared: " + joined(cleared));
  return kDone;
}

int restart_front(const Options& options) {
  constexpr int kPatienceMs = 30'000;
  std::string refusal;
  if (ask_locally(options.server, "restart-front", &refusal, kPatienceMs)) {
    answer(options, dump(json{{"restarted", true}}), "a new front serves");
    return kDone;
  }
  if (!refusal.empty()) {
    complain("%s", refusal);
    return kRefused;
  }
  complain("no hapticd on this host serves at %s", options.server);
  return kUnreachable;
}

/// Examines the host that it runs on; needs no server.
int doctor(const Options& options) {
  StiffnessQuestion question;
  question.device_damping = options.device_damping;
  question.rendered_damping = options.damping;
  constexpr double kSeconds = 10.0;
  const double seconds = options.seconds > 0.0 ? options.seconds : kSeconds;
  if (!options.json) complain("measuring %g s of a bare 1 kHz loop ...", seconds);
  const Report report = examine(HostFiles(), ask_host(seconds, question.period_s), question);
  say("%s\n", (options.json ? to_json(report, question) : to_text(report, question)).c_str());
  return report.grade == "unfit" ? kFailed : kDone;
}

}  // namespace haptic::ctl
