#include "tests/support/link/scenario.hpp"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

#include "tests/support/message_of.hpp"

namespace haptic::test {
namespace {

TEST(Scenario, RefusesByFieldAndValue) {
  const std::pair<const char*, const char*> cases[] = {
      {"up { loss: 1.5 }", "s: up.loss = 1.5: must be 0..1"},
      {"down { delay_ms: nan }", "s: down.delay_ms = nan: must be >= 0"},
      {"nonsense: 1", "s: not a Scenario"}};
  for (const auto& [text, expected] : cases) {
    EXPECT_EQ(
        message_of<std::runtime_error>([&, text = text] { return parse_scenario(text, "s"); }),
        expected);
  }
}

TEST(Scenario, EachShippedHasItsOwnSeed) {
  std::set<std::uint64_t> seeds;
  for (const Scenario& scenario : shipped_scenarios()) seeds.insert(scenario.seed);
  EXPECT_EQ(seeds.size(), shipped_scenarios().size());
  EXPECT_EQ(seeds.size(), 33U);
}

}  // namespace
}  // namespace haptic::test
