/// A fixed count of damaged inputs for every target, the same in every run; run.sh goes on for as
/// long as one likes, guided by coverage.

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/fuzz/targets.hpp"
#include "tests/support/link/random.hpp"

namespace haptic::test {
namespace {

/// Bytes changed, cut out, doubled, made extreme.
FuzzBytes mutated(FuzzBytes input, Random& random, std::size_t longest) {
  static constexpr std::uint8_t kExtremes[] = {0x00, 0x01, 0x7F, 0x80, 0xF0, 0xFF};
  const std::uint64_t edits = 1 + random.next() % 6;
  for (std::uint64_t k = 0; k < edits && !input.empty(); ++k) {
    const auto at = input.begin() + static_cast<std::ptrdiff_t>(random.next() % input.size());
    const auto until =
        at + std::min<std::ptrdiff_t>(input.end() - at, 1 + static_cast<int>(random.next() % 24));
    switch (random.next() % 5) {
      case 0:
        *at = static_cast<std::uint8_t>(random.next());
        break;
      case 1:
        *at ^= static_cast<std::uint8_t>(1U << random.next() % 8);
        break;
      case 2:
        std::fill(at, until, kExtremes[random.next() % std::size(kExtremes)]);
        break;
      case 3:
        input.erase(at, until);
        break;
      default: {
        const FuzzBytes piece(at, until);
        input.insert(input.begin() + static_cast<std::ptrdiff_t>(random.next() % input.size()),
                     piece.begin(), piece.end());
        break;
      }
    }
  }
  input.resize(std::min(input.size(), longest));
  return input;
}

/// Seeds as they are, then mutations of mutations: what has no finding may become the next parent.
void fuzz(const FuzzTarget& target, int executions) {
  std::vector<FuzzBytes> parents = target.seeds();
  ASSERT_FALSE(parents.empty());
  for (const FuzzBytes& seed : parents) ASSERT_EQ(target.run(seed), "");
  Random random(20);
  const std::size_t first = parents.size();
  for (int i = 0; i < executions; ++i) {
    FuzzBytes input = mutated(parents[random.next() % parents.size()], random, target.longest);
    ASSERT_EQ(target.run(input), "") << target.name << ", execution " << i;
    if (random.next() % 8 != 0) continue;
    if (parents.size() < first + 256) parents.emplace_back();
    parents[first + random.next() % (parents.size() - first)] = std::move(input);
  }
}

TEST(Fuzz, DatagramsDoNoHarm) {
  fuzz(datagram_target(), 50'000);
}

TEST(Fuzz, AnyFrontDoesNoHarm) {
  fuzz(crossing_target(), 20'000);
}

TEST(Fuzz, SerialFramesAreKept) {
  fuzz(frame_target(), 50'000);
}

TEST(Fuzz, AnyRecordingPlaysOrIsRefused) {
  fuzz(replay_target(), 5'000);
}

TEST(Fuzz, AnySceneLoadsOrIsRefused) {
  fuzz(scene_target(), 1'000);
}

}  // namespace
}  // namespace haptic::test
