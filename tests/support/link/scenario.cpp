#include "tests/support/link/scenario.hpp"

#include <google/protobuf/text_format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "tests/relay/scenario.pb.h"

namespace haptic::test {
namespace {

const std::string kShipped = HAPTIC_SOURCE_DIR "/tests/relay/scenarios";

/// Reads the numbers of a message; an error names the field, its value and what is allowed.
class Checker {
 public:
  explicit Checker(std::string where) : where_(std::move(where)) {}

  [[noreturn]] void refuse(const std::string& field, double value, const char* allowed) const {
    std::ostringstream text;
    text << where_ << field << " = " << value << ": must be " << allowed;
    throw std::runtime_error(text.str());
  }
  [[nodiscard]] double at_least_0(const std::string& field, double value) const {
    if (!(value >= 0.0) || std::isinf(value)) refuse(field, value, ">= 0");
    return value;
  }
  [[nodiscard]] double share(const std::string& field, double value) const {
    if (!(value >= 0.0 && value <= 1.0)) refuse(field, value, "0..1");
    return value;
  }
  [[nodiscard]] LinkTime milliseconds(const std::string& field, double value) const {
    return LinkTime(std::llround(at_least_0(field, value) * 1e6));
  }
  [[nodiscard]] std::vector<Window> windows(
      const std::string& field,
      const google::protobuf::RepeatedPtrField<v1::Window>& messages) const {
    std::vector<Window> windows;
    for (const v1::Window& message : messages) {
      const LinkTime from = milliseconds(field + ".from_s", 1e3 * message.from_s());
      const LinkTime to = milliseconds(field + ".to_s", 1e3 * message.to_s());
      if (to <= from) refuse(field + ".to_s", message.to_s(), "above from_s");
      windows.push_back({from, to, static_cast<Carrier>(message.carrier())});
    }
    return windows;
  }

 private:
  std::string where_;
};

WayRules way(const v1::Way& message, const std::string& where) {
  const Checker check(where);
  WayRules way{.delay = check.milliseconds("delay_ms", message.delay_ms()),
               .jitter_sigma = check.milliseconds("jitter_sigma_ms", message.jitter_sigma_ms()),
               .keep_order = message.keep_order(),
               .loss = check.share("loss", message.loss())};
  for (const v1::Burst& burst : message.burst()) {
    way.bursts.push_back({check.milliseconds("burst.every_ms", burst.every_ms()),
                          check.milliseconds("burst.length_ms", burst.length_ms())});
    if (way.bursts.back().length.count() == 0) {
      check.refuse("burst.length_ms", burst.length_ms(), "> 0");
    }
  }
  way.reorder = check.share("reorder", message.reorder());
  way.reorder_by = check.milliseconds("reorder_by_ms", message.reorder_by_ms());
  way.duplicate = check.share("duplicate", message.duplicate());
  way.partitions = check.windows("partition", message.partition());
  way.stalls = check.windows("stall", message.stall());
  way.bytes_per_second = check.at_least_0("rate_kbit_s", message.rate_kbit_s()) * 1e3 / 8.0;
  way.queue_bytes = check.at_least_0("queue_bytes", message.queue_bytes());
  if (way.bytes_per_second > 0.0 && way.queue_bytes == 0.0) {
    check.refuse("queue_bytes", 0.0, "> 0 where there is a rate");
  }
  return way;
}

}  // namespace

Scenario parse_scenario(const std::string& text, const std::string& name) {
  v1::Scenario message;
  if (!google::protobuf::TextFormat::ParseFromString(text, &message)) {
    throw std::runtime_error(name + ": not a Scenario");
  }
  const Checker check(name + ": ");
  if (message.what().empty()) throw std::runtime_error(name + ": what: is missing");
  if (!(message.duration_s() > 0.0)) check.refuse("duration_s", message.duration_s(), "> 0");
  Scenario scenario{.name = name, .what = message.what()};
  if (message.seed() != 0) scenario.seed = message.seed();
  scenario.duration = check.milliseconds("duration_s", 1e3 * message.duration_s());
  scenario.up = way(message.up(), name + ": up.");
  scenario.down = way(message.down(), name + ": down.");
  scenario.client_clock.drift = message.client_clock().drift_ppm() * 1e-6;
  for (const auto& step : message.client_clock().step()) {
    scenario.client_clock.steps.push_back(
        {check.milliseconds("client_clock.step.at_s", 1e3 * step.at_s()),
         LinkTime(std::llround(step.by_s() * 1e9))});
  }
  return scenario;
}

Scenario read_scenario(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error("cannot read " + file.string());
  std::stringstream text;
  text << stream.rdbuf();
  return parse_scenario(text.str(), file.stem().string());
}

Scenario shipped_scenario(const std::string& name) {
  return read_scenario(kShipped + "/" + name + ".textproto");
}

std::vector<Scenario> shipped_scenarios() {
  std::vector<Scenario> scenarios;
  for (const auto& entry : std::filesystem::directory_iterator(kShipped)) {
    if (entry.path().extension() == ".textproto") scenarios.push_back(read_scenario(entry.path()));
  }
  std::sort(scenarios.begin(), scenarios.end(),
            [](const Scenario& a, const Scenario& b) { return a.name < b.name; });
  return scenarios;
}

}  // namespace haptic::test
