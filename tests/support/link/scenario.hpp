#pragma once
/// A scenario of trouble (tests/relay/scenario.proto) as plain values, checked.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

namespace haptic::test {

/// Time since the scenario's start.
using LinkTime = std::chrono::nanoseconds;

enum class Carrier : std::uint8_t { kAll, kUdp, kTcp };

struct BurstRule {
  LinkTime every{0};   ///< mean pause between two
  LinkTime length{0};  ///< > 0
};

/// [from, to)
struct Window {
  LinkTime from{0}, to{0};
  Carrier carrier{Carrier::kAll};
  [[nodiscard]] bool holds(LinkTime at, Carrier who) const noexcept {
    return at >= from && at < to && (carrier == Carrier::kAll || carrier == who);
  }
};

struct WayRules {
  LinkTime delay{0}, jitter_sigma{0};
  bool keep_order{false};
  double loss{0.0};
  std::vector<BurstRule> bursts{};
  double reorder{0.0};
  LinkTime reorder_by{0};
  double duplicate{0.0};
  std::vector<Window> partitions{}, stalls{};
  double bytes_per_second{0.0};  ///< 0: no limit
  double queue_bytes{0.0};
};

struct ClockStep {
  LinkTime at{0}, by{0};
};

struct ClockRules {
  double drift{0.0};  ///< share, not ppm
  std::vector<ClockStep> steps{};
};

struct Scenario {
  std::string name{};  ///< of the file, without its ending
  std::string what{};
  std::uint64_t seed{1};
  LinkTime duration{0};
  WayRules up{}, down{};
  ClockRules client_clock{};
};

/// For GoogleTest: prints a scenario's name.
inline void PrintTo(const Scenario& scenario, std::ostream* out) {
  *out << scenario.name;
}

/// Throws std::runtime_error: "FILE: up.loss = 1.5: must be 0..1".
[[nodiscard]] Scenario read_scenario(const std::filesystem::path& file);
[[nodiscard]] Scenario parse_scenario(const std::string& text, const std::string& name);
/// The file of that name (without ending) in tests/relay/scenarios.
[[nodiscard]] Scenario shipped_scenario(const std::string& name);
/// All of that folder, by name.
[[nodiscard]] std::vector<Scenario> shipped_scenarios();

}  // namespace haptic::test
