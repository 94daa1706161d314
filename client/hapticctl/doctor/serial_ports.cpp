#include <sys/stat.h>

#include <algorithm>
#include <sstream>

#include "doctor/checks.hpp"

namespace haptic::ctl {
namespace {

std::string group_name(const HostFiles& host, gid_t group) {
  std::istringstream lines(host.text("/etc/group").value_or(""));
  for (std::string line; std::getline(lines, line);) {
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    if (std::to_string(group) == line.substr(second + 1, line.find(':', second + 1) - second - 1)) {
      return line.substr(0, first);
    }
  }
  return std::to_string(group);
}

bool may_use(const HostFiles::Ownership& port, const HostAnswers& answers) {
  if (answers.user == 0) return true;
  const auto allows = [&](mode_t bits) { return (port.mode & bits) == bits; };
  if (port.user == answers.user) return allows(S_IRUSR | S_IWUSR);
  const bool in_group =
      std::find(answers.groups.begin(), answers.groups.end(), port.group) != answers.groups.end();
  return allows(in_group ? S_IRGRP | S_IWGRP : S_IROTH | S_IWOTH);
}

std::string latency_file(const std::string& port) {
  return "/sys/bus/usb-serial/devices/" + port.substr(port.find_last_of('/') + 1) +
         "/latency_timer";
}

Finding check_port(const HostFiles& host, const HostAnswers& answers, const std::string& port) {
  Finding finding{"serial", Health::kGood, port + ": may be opened", ""};
  const auto ownership = host.ownership(port);
  if (!ownership)
    return {"serial", Health::kBad, port + ": exists, but its owner and mode cannot be read", ""};
  if (!may_use(*ownership, answers)) {
    finding.health = Health::kBad;
    finding.found = port + ": may not be opened by this user";
    finding.advice =
        "usermod -aG " + group_name(host, ownership->group) + " USER, then log in again";
    return finding;
  }
  const auto timer = host.number(latency_file(port));
  if (!timer) return finding;
  finding.found += ", latency timer " + std::to_string(*timer) + " ms";
  if (*timer <= 1) return finding;
  finding.health = Health::kImpaired;
  finding.advice = "echo 1 > " + latency_file(port) + " (it delays samples)";
  return finding;
}

}  // namespace

std::vector<Finding> check_serial(const HostFiles& host, const HostAnswers& answers) {
  std::vector<Finding> findings;
  for (const char* kind : {"ttyACM", "ttyUSB"}) {
    for (const std::string& port : host.entries("/dev", kind)) {
      findings.push_back(check_port(host, answers, port));
    }
  }
  if (findings.empty()) {
    findings.push_back({"serial", Health::kGood, "no USB serial port is plugged in", ""});
  }
  return findings;
}

double serial_latency(const HostFiles& host) {
  double longest = 0.0;
  for (const std::string& port : host.entries("/dev", "ttyUSB")) {
    longest =
        std::max(longest, 1e-3 * static_cast<double>(host.number(latency_file(port)).value_or(0)));
  }
  return longest;
}

}  // namespace haptic::ctl
