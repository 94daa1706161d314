#include "table.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "commands.hpp"

namespace haptic::ctl {

namespace {

template <typename... Arguments>
std::string text(const char* format, Arguments... arguments) {
  char buffer[256];
  std::snprintf(buffer, sizeof buffer, format, arguments...);
  return buffer;
}

/// A force as a bar about the middle: "[     ###|        ]".
std::string bar(double value, double limit) {
  constexpr int kHalf = 12;
  const int filled =
      limit > 0.0 && std::isfinite(value)
          ? std::clamp(static_cast<int>(std::lround(value / limit * kHalf)), -kHalf, kHalf)
          : 0;
  std::string drawn(2 * kHalf + 1, ' ');
  drawn[kHalf] = '|';
  for (int i = 1; i <= std::abs(filled); ++i) {
    drawn[static_cast<std::size_t>(filled < 0 ? kHalf - i : kHalf + i)] = '#';
  }
  return "[" + drawn + "]";
}

/// Age and its meaning; without a proxy there is none.
std::string age(const client::DeviceState& s) {
  if (s.proxy_seq_used == 0) return "no proxy";
  return text("%s, age %.1f ms", client::name(s.staleness),
              static_cast<double>(s.proxy_age.count()) * 1e-3);
}

/// Who says where the palm is, and how old that is; empty where the scene has no tracker.
std::string tracker(const client::DeviceInfo& device, const client::DeviceState& s) {
  if (!s.tracker) return {};
  const std::string who = device.tracker.empty() ? "nobody" : device.tracker;
  if (s.tracker->seq_used == 0) return "tracker " + who + ", no pose";
  return text("tracker %s, pose %llu %s, age %.1f ms", who.c_str(),
              static_cast<unsigned long long>(s.tracker->seq_used),
              client::name(s.tracker->staleness),
              static_cast<double>(s.tracker->age.count()) * 1e-3);
}

double at(const std::vector<double>& values, std::size_t i) {
  return i < values.size() ? values[i] : std::nan("");
}

const char* mode_name(client::Mode mode) {
  switch (mode) {
    case client::Mode::kHeld:
      return "held";
    case client::Mode::kPlanes:
      return "planes";
    case client::Mode::kFree:
      return "free";
    case client::Mode::kNone:
      break;
  }
  return "none";
}

}  // namespace

Rows table(const client::DeviceInfo& device, const client::DeviceState& s, double seconds,
           std::uint64_t conflated) {
  Rows rows{text("%s  %s  %s  %s  gain %.2f  %s  t %.1f s", device.name.c_str(),
                 client::name(s.state), mode_name(s.mode), age(s).c_str(), s.gain,
                 s.proxy_seq_used == 0 ? "-" : client::name(s.carrier), seconds)};
  std::size_t actuated = 0;
  for (std::size_t i = 0; i < device.dofs.size(); ++i) {
    const auto& dof = device.dofs[i];
    std::string row = text("  %-10s q %9.5f  q* %9.5f %-3s", dof.name.c_str(), at(s.q, i),
                           at(s.q_star, i), dof.unit.c_str());
    if (dof.actuated) {
      const double tau = at(s.tau_a, actuated), limit = at(device.force_limit, actuated);
      row += text("  tau_a %7.2f / %g %s ", tau, limit, effort_unit(dof.unit).c_str()) +
             bar(tau, limit);
      ++actuated;
    }
    rows.push_back(row);
  }
  for (std::size_t i = 0; i < device.coordinates.size(); ++i) {
    rows.push_back(text("  %-10s x_probe %9.5f  proxy %9.5f %s", device.coordinates[i].name.c_str(),
                        at(s.x_probe, i), at(s.x, i), device.coordinates[i].unit.c_str()));
  }
  if (s.tracker) rows.push_back("  " + tracker(device, s));
  if (s.certificate) {
    const bool computed = s.certificate->status == client::CertificateState::Status::kComputed;
    rows.push_back(computed ? text("  certificate %.3f (block %u)", s.certificate->margin,
                                   s.certificate->block)
                            : text("  certificate %s", client::name(s.certificate->status)));
  }
  rows.push_back(text("  faults %s  limiters %s  conflated %llu",
                      joined(client::fault_names(s.faults)).c_str(),
                      joined(client::limiter_names(s.limiters)).c_str(),
                      static_cast<unsigned long long>(conflated)));
  return rows;
}

std::string line(const client::DeviceInfo& device, const client::DeviceState& s, double seconds) {
  std::string all = text("%9.3f s  %s  %-9s %s  gain %.2f ", seconds, device.name.c_str(),
                         client::name(s.state), age(s).c_str(), s.gain);
  for (std::size_t i = 0; i < s.q.size(); ++i) all += text(" q%zu %8.5f", i, s.q[i]);
  for (const double tau : s.tau_a) all += text("  tau_a %7.3f", tau);
  if (s.tracker) all += "  " + tracker(device, s);
  return all + "  faults " + joined(client::fault_names(s.faults));
}

std::string json_line(const client::DeviceInfo& device, const client::DeviceState& s,
                      std::uint64_t conflated) {
  nlohmann::json passivity;  // null where the scene has neither tank nor observer
  if (s.passivity) {
    passivity = {{"tank_j", s.passivity->tank},
                 {"storage_j", s.passivity->storage},
                 {"scale", s.passivity->scale},
                 {"observed_j", s.passivity->observed},
                 {"alpha_s", s.passivity->alpha}};
  }
  nlohmann::json certificate;  // null where the scene does not ask for it
  if (s.certificate) {
    certificate = {{"status", client::name(s.certificate->status)},
                   {"margin", s.certificate->margin},
                   {"block", s.certificate->block}};
  }
  nlohmann::json coupling = nlohmann::json::array();
  for (const client::CouplingBlock& block : s.coupling_metric) {
    coupling.push_back({{"coordinates", block.coordinates}, {"lower", block.lower}});
  }
  nlohmann::json palm;  // null where the scene has no tracker
  if (s.tracker) {
    palm = {{"holder", device.tracker},
            {"seq_used", s.tracker->seq_used},
            {"age_us", s.tracker->age.count()},
            {"staleness", client::name(s.tracker->staleness)}};
  }
  return nlohmann::json({{"device", device.name},
                         {"seq", s.seq},
                         {"server_time_ns", s.server_time_ns},
                         {"state", client::name(s.state)},
                         {"mode", mode_name(s.mode)},
                         {"staleness", client::name(s.staleness)},
                         {"proxy_seq_used", s.proxy_seq_used},
                         {"proxy_age_us", s.proxy_age.count()},
                         {"gain", s.gain},
                         {"transport", client::name(s.carrier)},
                         {"q", s.q},
                         {"q_dot", s.q_dot},
                         {"x_probe", s.x_probe},
                         {"x", s.x},
                         {"q_star", s.q_star},
                         {"tau_a", s.tau_a},
                         {"tau_elastic", s.tau_elastic},
                         {"faults", s.faults},
                         {"fault_names", client::fault_names(s.faults)},
                         {"limiters", s.limiters},
                         {"actuator_limiters", s.actuator_limiters},
                         {"tau_measured", s.tau_measured},
                         {"temperature_c", s.temperature_c},
                         {"drive", s.drive},
                         {"active_planes", s.active_planes},
                         {"passivity", passivity},
                         {"tracker", palm},
                         {"certificate", certificate},
                         {"coupling_metric", coupling},
                         {"projection", s.projection},
                         {"lease_epoch", s.lease_epoch},
                         {"conflated", conflated}})
      .dump();
}

std::string loop_row(const client::ServerInfo& server) {
  return text("loop: %llu ticks, %llu skipped, late %.1f us p50, %.1f us p99; tick %.2f us p50",
              static_cast<unsigned long long>(server.ticks),
              static_cast<unsigned long long>(server.skipped_ticks), server.lateness_p50_us,
              server.lateness_p99_us, server.tick_p50_us);
}

void Screen::show(const Rows& rows) {
  winsize size{};
  const bool known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  // A row that wraps would be two, and the next refresh would land below the last.
  const std::size_t width = known ? size.ws_col : 80;
  if (shown_ > 0) std::printf("\x1b[%zuA", shown_);
  for (const std::string& row : rows) std::printf("%s\x1b[K\n", row.substr(0, width - 1).c_str());
  std::fflush(stdout);
  shown_ = rows.size();
}

}  // namespace haptic::ctl
