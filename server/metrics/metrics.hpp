#pragma once
/// The metrics of the daemon as one page of Prometheus' text format. Names and units follow
/// Prometheus' conventions: base units, _total for counters; server/README.md lists them.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "haptic/core/tick/ring.hpp"
#include "hw/device.hpp"
#include "server/crossing/server_facts.hpp"
#include "server/metrics/tick_metrics.hpp"
#include "server/session/device_sessions.hpp"

namespace haptic::server {

/// Where the numbers come from; everything must outlive what asks. All are read on the thread of
/// the scrape, none of them waits for the loop.
struct MetricsSources {
  struct Device {
    DeviceSessions* sessions{nullptr};
    const TickMetrics* ticks{nullptr};
    const core::Ring<core::TickRecord>* records{nullptr};
    const hw::Device* device{nullptr};
  };
  std::vector<Device> devices{};
  FactsProvider facts{};
  std::function<unsigned()> sessions{};
  /// By reason; empty where there is no UDP path.
  std::function<std::vector<std::pair<std::string, std::uint64_t>>()> dropped_datagrams{};
};

[[nodiscard]] std::string metrics_text(const MetricsSources& sources);

}  // namespace haptic::server
