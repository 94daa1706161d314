#include "tests/support/link/scenario.hpp"

#include <google/protobuf/text_format.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "tests/relay/scenario.pb.h"

namespace haptic::test {
namespace {

const std::string kShipped = HAPTIC_SOURCE_DIR "/tests/relay/scenarios";

/// `value`, which must be in [0, most]; an error names the field, its value and what is allowed.
double checked(const std::string& field, double value, double most = DBL_MAX) {
  if (value >= 0.0 && value <= most) return value;
  std::ostringstream text;
  text << field << " = " << value << ": must be " << (most == 1.0 ? "0..1" : ">= 0");
  throw std::runtime_error(text.str());
}

LinkTime milliseconds(const std::string& field, double value) {
  return LinkTime(std::llround(checked(field, value) * 1e6));
}

std::vector<Window> windows(const std::string& field,
                            const google::protobuf::RepeatedPtrField<v1::Window>& messages) {
  std::vector<Window> windows;
  for (const v1::Window& message : messages) {
    windows.push_back({milliseconds(field + ".from_s", 1e3 * message.from_s()),
                       milliseconds(field + ".to_s", 1e3 * message.to_s()),
                       static_cast<Carrier>(message.carrier())});
  }
  return windows;
}

WayRules way(const v1::Way& message, const std::string& where) {
  WayRules way{
      .delay = milliseconds(where + "delay_ms", message.delay_ms()),
      .jitter_sigma = milliseconds(where + "jitter_sigma_ms", message.jitter_sigma_ms()),
      .keep_order = message.keep_order(),
      .loss = checked(where + "loss", message.loss(), 1.0),
      .reorder = checked(where + "reorder", message.reorder(), 1.0),
      .reorder_by = milliseconds(where + "reorder_by_ms", message.reorder_by_ms()),
      .duplicate = checked(where + "duplicate", message.duplicate(), 1.0),
      .partitions = windows(where + "partition", message.partition()),
      .stalls = windows(where + "stall", message.stall()),
      .bytes_per_second = checked(where + "rate_kbit_s", message.rate_kbit_s()) * 1e3 / 8.0,
      .queue_bytes = checked(where + "queue_bytes", message.queue_bytes())};
  for (const v1::Burst& burst : message.burst()) {
    if (!(burst.length_ms() > 0.0))
      throw std::runtime_error(where + "burst.length_ms: must be > 0");
    way.bursts.push_back({milliseconds(where + "burst.every_ms", burst.every_ms()),
                          milliseconds(where + "burst.length_ms", burst.length_ms())});
  }
  return way;
}

}  // namespace

Scenario parse_scenario(const std::string& text, const std::string& name) {
  v1::Scenario message;
  if (!google::protobuf::TextFormat::ParseFromString(text, &message)) {
    throw std::runtime_error(name + ": not a Scenario");
  }
  Scenario scenario{.name = name, .what = message.what()};
  if (message.seed() != 0) scenario.seed = message.seed();
  scenario.duration = milliseconds(name + ": duration_s", 1e3 * message.duration_s());
  scenario.up = way(message.up(), name + ": up.");
  scenario.down = way(message.down(), name + ": down.");
  scenario.client_clock.drift = message.client_clock().drift_ppm() * 1e-6;
  for (const auto& step : message.client_clock().step()) {
    scenario.client_clock.steps.push_back(
        {milliseconds(name + ": client_clock.step.at_s", 1e3 * step.at_s()),
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
