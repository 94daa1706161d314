#include "tests/support/link/scenario.hpp"

#include <gtest/gtest.h>

#include <set>

namespace haptic::test {
namespace {

std::string refusal(const std::string& text) {
  try {
    static_cast<void>(parse_scenario(text, "s"));
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Scenario, RefusesByFieldAndValue) {
  const std::string good = R"(what: "x" duration_s: 1 )";
  EXPECT_EQ(refusal(good), "accepted");
  const std::pair<const char*, const char*> cases[] = {
      {"up { loss: 1.5 }", "s: up.loss = 1.5: must be 0..1"},
      {"down { loss: -0.1 }", "s: down.loss = -0.1: must be 0..1"},
      {"up { delay_ms: -1 }", "s: up.delay_ms = -1: must be >= 0"},
      {"up { delay_ms: nan }", "s: up.delay_ms = nan: must be >= 0"},
      {"up { duplicate: 2 }", "s: up.duplicate = 2: must be 0..1"},
      {"up { burst { every_ms: 5 } }", "s: up.burst.length_ms = 0: must be > 0"},
      {"up { partition { from_s: 2 to_s: 2 } }", "s: up.partition.to_s = 2: must be above from_s"},
      {"up { rate_kbit_s: 5 }", "s: up.queue_bytes = 0: must be > 0 where there is a rate"},
      {"nonsense: 1", "s: not a Scenario"}};
  for (const auto& [text, expected] : cases) EXPECT_EQ(refusal(good + text), expected);
  EXPECT_EQ(refusal("duration_s: 1"), "s: what: is missing");
  EXPECT_EQ(refusal(R"(what: "x")"), "s: duration_s = 0: must be > 0");
}

TEST(Scenario, EachShippedHasItsOwnSeed) {
  std::set<std::uint64_t> seeds;
  for (const Scenario& scenario : shipped_scenarios()) seeds.insert(scenario.seed);
  EXPECT_EQ(seeds.size(), shipped_scenarios().size());
  EXPECT_EQ(seeds.size(), 33U);
}

}  // namespace
}  // namespace haptic::test
