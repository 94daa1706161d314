#include <fstream>
#include <random>
#include <sstream>

#include "tests/server/owner/scene/scene_text.hpp"

namespace haptic::test {
namespace {

/// Damages a text as editors, disks and hurried people do.
std::string mutated(std::string text, std::mt19937_64& random) {
  static const std::vector<std::string> kPieces = {"-1e308",    "nan",
                                                   "1e-320",    "{",
                                                   "}",         "[",
                                                   "\"",        "#",
                                                   "device {}", "18446744073709551616",
                                                   "linear {",  "actuated: true",
                                                   ": ",        "\n",
                                                   "A: 3",      std::string(1, '\0'),
                                                   "\xff\xfe"};
  const std::uint64_t edits = 1 + random() % 4;
  for (std::uint64_t k = 0; k < edits && !text.empty(); ++k) {
    const std::size_t at = random() % text.size();
    switch (random() % 5) {
      case 0:
        text[at] = static_cast<char>(random());
        break;
      case 1:
        text.erase(at, 1 + random() % 20);
        break;
      case 2:
        text.insert(at, text.substr(random() % text.size(), random() % 60));
        break;
      case 3:
        text.insert(at, kPieces[random() % kPieces.size()]);
        break;
      default:
        text.replace(at, random() % 6, kPieces[random() % kPieces.size()]);
        break;
    }
  }
  return text;
}

TEST(SceneMutations, ScenesLoadOrAreRefused) {
  std::vector<std::string> seeds = {kFinger, kLinear};
  for (const char* name : {"linear_underactuated.textproto", "finger_soft_grasp.textproto",
                           "stylus_three_of_six.textproto", "stylus_cartesian.textproto",
                           "chain_redundant.textproto"}) {
    std::ifstream stream(kScenes / name);
    std::stringstream whole;
    whole << stream.rdbuf();
    ASSERT_GT(whole.str().size(), 100u) << name;
    seeds.push_back(whole.str());
  }
  std::mt19937_64 random(7);
  int loaded = 0, refused = 0;
  for (int i = 0; i < 2000; ++i) {
    try {
      const server::Scene scene = parse(mutated(seeds[i % seeds.size()], random));
      ASSERT_EQ(parse(scene.resolved).resolved, scene.resolved) << "mutation " << i;
      ++loaded;
    } catch (const core::SceneError& error) {
      ASSERT_STRNE(error.what(), "");
      ++refused;
    }
  }
  EXPECT_GT(loaded, 50);
  EXPECT_GT(refused, 500);
}

TEST(SceneMutations, OverridesAreSetOrRefused) {
  const std::vector<std::string> seeds = {
      "device[0].impedance.stiffness_n_per_m[0]=800", "server.listen=[\"127.0.0.1:1\"]",
      "device[0].standard={}", "loop={period {nanos: 2000000}}"};
  std::mt19937_64 random(8);
  int loaded = 0, refused = 0;
  for (int i = 0; i < 1000; ++i) {
    try {
      static_cast<void>(parse(kFinger, {mutated(seeds[i % seeds.size()], random)}));
      ++loaded;
    } catch (const core::SceneError&) {
      ++refused;
    }
  }
  EXPECT_GT(loaded, 0);
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace haptic::test
