#pragma once
/// The metrics of the daemon as one page of Prometheus' text format. Names and units follow
/// Prometheus' conventions: base units, _total for counters; server/README.md lists them.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "server/crossing/ports.hpp"
#include "server/crossing/server_facts.hpp"
#include "server/crossing/tick_totals.hpp"

namespace haptic::server {

/// The sources of the numbers of one scrape. None waits for the loop.
struct MetricsSources {
  const OwnerPort* owner{nullptr};
  std::function<TickTotals(std::size_t device)> totals{};
  FactsProvider facts{};
  /// Dropped datagrams by reason; empty if there is no UDP path.
  std::vector<std::pair<std::string, std::uint64_t>> dropped_datagrams{};
  /// Open; cut since the start.
  std::pair<std::size_t, std::uint64_t> connections{};
};

[[nodiscard]] std::string metrics_text(const MetricsSources& sources);

}  // namespace haptic::server
