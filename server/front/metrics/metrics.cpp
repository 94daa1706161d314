#include "server/front/metrics/metrics.hpp"

#include <algorithm>
#include <cctype>
#include <vector>

#include "haptic/schema/fields.hpp"
#include "haptic/v1/haptic_service.pb.h"
#include "server/base/process.hpp"
#include "server/front/metrics/exposition.hpp"
#include "server/front/session/link_watch.hpp"

namespace haptic::server {
namespace {

/// One scrape's copy, so that all lines are of the same moment.
struct Reading {
  std::string name{};
  DeviceStatus status{};
  TickTotals ticks{};
  std::vector<std::string> actuators{};
};

/// "ENERGY_TANK" as a label's value: "energy_tank".
std::string lower(std::string_view name) {
  std::string out(name);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

double count(std::uint64_t value) {
  return static_cast<double>(value);
}

void process(Exposition& page, const ServerFacts& facts) {
  page.gauge("haptic_build_info", "What runs: always 1.");
  page.sample({{"version", facts.version}, {"scene", facts.scene}}, 1.0);
  page.gauge("haptic_realtime_info", "What the host granted of real time: always 1.");
  page.sample({{"grade", facts.realtime.grade}}, 1.0);
  page.gauge("haptic_uptime_seconds", "Time since the start.");
  page.sample({}, core::seconds(facts.uptime));
  page.gauge("process_resident_memory_bytes", "Resident memory size in bytes, of each process.");
  page.sample({{"process", "owner"}}, count(facts.resident_bytes));
  page.sample({{"process", "front"}}, count(resident_bytes()));
  page.counter("haptic_front_starts_total", "Fronts that served since the start.");
  page.sample({}, count(facts.fronts_served));
}

/// One loop ticks all devices: what the first saw of it is the loop's.
void loop(Exposition& page, const ServerFacts& facts, const TickTotals& ticks) {
  page.counter("haptic_loop_ticks_total", "Ticks of the loop.");
  page.sample({}, count(facts.loop.ticks));
  page.counter("haptic_loop_skipped_deadlines_total", "Deadlines that passed without a tick.");
  page.sample({}, count(facts.loop.skipped));
  if (!facts.loop.paced_by.empty()) {
    page.counter(
        "haptic_loop_sample_paced_ticks_total",
        "Ticks begun by a sample of the board that paces the loop; the others by the timer.");
    page.sample({{"device", facts.loop.paced_by}}, count(facts.loop.paced_by_sample));
  }
  page.histogram("haptic_loop_period_seconds", "Time from one tick to the next.");
  page.sample({}, ticks.period);
  page.histogram("haptic_loop_lateness_seconds", "Wake-up of the loop behind its deadline.");
  page.sample({}, ticks.lateness);
  page.gauge("haptic_loop_tick_seconds",
             "From the loop's wake-up to the end of its tick, of all devices, over the last 10 s.");
  page.sample({{"percentile", "50"}}, core::seconds(facts.loop.tick_time.p50));
  page.sample({{"percentile", "99"}}, core::seconds(facts.loop.tick_time.p99));
}

void proxies(Exposition& page, const std::vector<Reading>& devices) {
  page.histogram("haptic_proxy_age_seconds", "Age of the proxy at its use in a tick.");
  for (const Reading& d : devices) page.sample({{"device", d.name}}, d.ticks.age);

  page.counter("haptic_staleness_seconds_total", "Time spent at each staleness level of a lease.");
  for (const Reading& d : devices) {
    for (std::size_t i = 0; i < d.ticks.level_s.size(); ++i) {
      const std::string level =
          lower(schema::value_text(*v1::StalenessLevel_descriptor(), static_cast<int>(i) + 1));
      page.sample({{"device", d.name}, {"level", level}}, d.ticks.level_s[i]);
    }
  }
  page.counter("haptic_proxy_samples_total",
               "Proxy samples that came under a lease, by what became of them.");
  for (const Reading& d : devices) {
    for (std::size_t i = 0; i < kIngressVerdicts; ++i) {
      const auto verdict = static_cast<IngressVerdict>(i);
      page.sample({{"device", d.name}, {"verdict", lower(name(verdict))}},
                  count(d.status.samples[verdict]));
    }
  }
}

void carriers(Exposition& page, const std::vector<Reading>& devices,
              const std::vector<std::pair<std::string, std::uint64_t>>& dropped) {
  page.counter("haptic_carrier_seconds_total",
               "Time of a lease led by samples of each carrier; none: before the first sample.");
  for (const Reading& d : devices) {
    const char* const names[kCarriers] = {"none", "grpc", "udp", "websocket"};
    for (std::size_t i = 0; i < d.ticks.carrier_s.size(); ++i) {
      page.sample({{"device", d.name}, {"carrier", names[i]}}, d.ticks.carrier_s[i]);
    }
  }
  page.counter("haptic_carrier_changes_total",
               "Times the samples of a lease changed their carrier.");
  for (const Reading& d : devices) {
    page.sample({{"device", d.name}}, count(d.ticks.carrier_changes));
  }
  if (dropped.empty()) return;
  page.counter("haptic_udp_dropped_datagrams_total", "Datagrams dropped without an answer.");
  for (const auto& [reason, n] : dropped) page.sample({{"reason", lower(reason)}}, count(n));
}

void connections(Exposition& page, const std::pair<std::size_t, std::uint64_t>& now) {
  page.gauge("haptic_connections", "Open connections.");
  page.sample({}, static_cast<double>(now.first));
  page.counter("haptic_connections_cut_total", "Connections cut because of their bounds.");
  page.sample({}, count(now.second));
}

/// Limiters and faults: every one that has a name, also at 0, so that a rate can be asked for
/// before the first.
void named(Exposition& page, const char* label, const Reading& d, int field,
           const std::array<std::uint64_t, 32>& counts) {
  const auto& bits = *v1::DeviceState::descriptor()->FindFieldByNumber(field);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const std::string name = schema::bit_names(bits, std::uint32_t{1} << i).front();
    if (std::isdigit(static_cast<unsigned char>(name.front())) != 0) continue;
    page.sample({{"device", d.name}, {label, lower(name)}}, count(counts[i]));
  }
}

void force(Exposition& page, const std::vector<Reading>& devices) {
  page.gauge("haptic_device_state", "1 for the state the device is in, 0 for the others.");
  for (const Reading& d : devices) {
    for (int s = 1; s <= static_cast<int>(core::LifecycleState::kClosing); ++s) {
      const std::string state = lower(schema::value_text(*v1::DeviceStateName_descriptor(), s));
      page.sample({{"device", d.name}, {"state", state}},
                  static_cast<int>(d.ticks.state) == s ? 1.0 : 0.0);
    }
  }
  page.gauge("haptic_gain_ratio", "Gain of the elastic force, 0 to 1.");
  for (const Reading& d : devices) page.sample({{"device", d.name}}, d.ticks.gain);
  page.gauge("haptic_force_error_bound",
             "Bound of the elastic force's error against the simulation, N or N m; only if known.");
  for (const Reading& d : devices) {
    for (std::size_t i = 0;
         i < std::min<std::size_t>(d.ticks.error_bound.count, d.actuators.size()); ++i) {
      page.sample({{"device", d.name}, {"actuator", d.actuators[i]}}, d.ticks.error_bound.value[i]);
    }
  }
  page.counter("haptic_limited_ticks_total", "Ticks in which a limiter held something back.");
  for (const Reading& d : devices) {
    named(page, "limiter", d, v1::DeviceState::kLimitersFieldNumber, d.ticks.limited);
  };
  page.counter("haptic_faults_total", "Times a fault latched.");
  for (const Reading& d : devices) {
    named(page, "fault", d, v1::DeviceState::kFaultsFieldNumber, d.ticks.faults);
  };
  page.counter("haptic_force_lost_total", "Times force was given up for a proxy that was too old.");
  for (const Reading& d : devices) page.sample({{"device", d.name}}, count(d.ticks.lost));
}

void people(Exposition& page, const std::vector<Reading>& devices) {
  unsigned sessions = 0;
  for (const Reading& d : devices) sessions += d.status.sessions;
  page.gauge("haptic_sessions", "Session streams that are open.");
  page.sample({}, sessions);
  page.gauge("haptic_device_controlled", "1 while a session holds the lease.");
  for (const Reading& d : devices)
    page.sample({{"device", d.name}}, d.status.controller.empty() ? 0.0 : 1.0);
  page.gauge("haptic_device_observers", "Sessions and watches without the lease.");
  for (const Reading& d : devices) page.sample({{"device", d.name}}, d.status.observers);
  page.counter("haptic_records_dropped_total",
               "Ticks that telemetry, and with it this page, missed.");
  for (const Reading& d : devices)
    page.sample({{"device", d.name}}, count(d.status.records_dropped));
}

/// The way to the device itself: samples as they were used, frames as both ends counted them.
void links(Exposition& page, const std::vector<Reading>& devices) {
  page.histogram("haptic_device_sample_age_seconds",
                 "Age of the device's newest sample at its use in a tick.");
  for (const Reading& d : devices) page.sample({{"device", d.name}}, d.ticks.sample_age);
  const auto has_link = [](const Reading& d) { return d.status.link_count > 0; };
  if (std::none_of(devices.begin(), devices.end(), has_link)) return;
  page.counter("haptic_link_frames_total",
               "Frames between a device and the server, by who counted and what became of them.");
  for (const Reading& d : devices) {
    for (std::size_t i = 0; i < d.status.link_count; ++i) {
      const LinkFrames& n = d.status.link[i];
      page.sample({{"device", d.name}, {"end", n.end}, {"what", n.what}}, count(n.frames));
    }
  }
}

}  // namespace

std::string metrics_text(const MetricsSources& sources) {
  std::vector<Reading> devices;
  for (std::size_t i = 0; i < sources.owner->devices().size(); ++i) {
    const DeviceFacts& facts = sources.owner->devices()[i];
    devices.push_back({facts.name, sources.owner->status(i), sources.totals(i), {}});
    v1::Device description;
    description.ParseFromString(facts.description);
    for (const v1::DegreeOfFreedom& dof : description.dofs()) {
      if (dof.actuated()) devices.back().actuators.push_back(dof.name());
    }
  }
  const ServerFacts facts = sources.facts();
  Exposition page;
  process(page, facts);
  if (!devices.empty()) loop(page, facts, devices.front().ticks);
  people(page, devices);
  proxies(page, devices);
  carriers(page, devices, sources.dropped_datagrams);
  connections(page, sources.connections);
  force(page, devices);
  links(page, devices);
  return page.text();
}

}  // namespace haptic::server
