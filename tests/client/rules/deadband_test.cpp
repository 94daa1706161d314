/// Which samples the server needs: vectors that the Python library is tested by too, and a server
/// behind a network that loses samples.

#include "haptic/client/deadband.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

namespace haptic::client {
namespace {

using nlohmann::json;
using std::chrono::duration_cast;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using Coordinates = std::vector<double>;

nanoseconds ns(double seconds) {
  return nanoseconds(std::llround(1e9 * seconds));
}

Plane plane_of(const json& told) {
  Plane plane;
  plane.normal = told.value("normal", Coordinates{1.0, 0.0});
  plane.offset = told.at("offset");
  plane.compliance = told.value("compliance", 0.0);
  plane.velocity = told.value("velocity", 0.0);
  plane.curvature = told.value("curvature", Coordinates{});
  plane.id = told.value("id", 0u);
  plane.mass = told.value("mass", 0.0);
  if (told.contains("uncertainty")) plane.uncertainty = told.at("uncertainty").get<double>();
  return plane;
}

Proxy proxy_of(const json& step) {
  if (step.at("mode") == "free") return Proxy::free();
  const auto position = step.value("position", Coordinates{});
  if (step.at("mode") == "held") return Proxy::held(position);
  std::vector<Plane> planes;
  for (const json& told : step.at("planes")) planes.push_back(plane_of(told));
  return Proxy::behind(planes, position);
}

TEST(Deadband, FollowsTheVectors) {
  const json vectors = json::parse(std::ifstream(HAPTIC_SOURCE_DIR "/tests/client/deadband.json"));
  for (const json& one : vectors.at("cases")) {
    std::vector<VirtualCoordinate> coordinates;
    for (const std::string& kind : one.value("kinds", std::vector<std::string>(2, "linear"))) {
      coordinates.push_back({"x", "m", kind});
    }
    Deadband deadband(coordinates, vectors.at("width"), vectors.at("rate_hz"));
    deadband.begin(ns(vectors.at("fresh_end_s")));
    std::uint64_t seq = 1;
    for (const json& step : one.at("steps")) {
      deadband.used(step.value("used", 0u));
      const auto at = Deadband::TimePoint(ns(1e-3 * step.at("at_ms").get<double>()));
      const bool news =
          deadband.is_news(seq, proxy_of(step), step.value("probe", Coordinates{}), at);
      EXPECT_EQ(news, step.at("news").get<bool>()) << one.at("name") << ": " << step;
      seq += news ? 1 : 0;
    }
  }
}

TEST(Deadband, ZeroSendsEverySample) {
  Deadband deadband({}, 0.0, 1000.0);
  deadband.begin(std::chrono::seconds(1));
  for (std::uint64_t seq = 1; seq < 4; ++seq) {
    deadband.used(seq - 1);
    EXPECT_TRUE(deadband.is_news(seq, Proxy::free(), {}, {}));
  }
}

TEST(Deadband, ValidForShortensTheSilence) {
  Deadband deadband({}, 1e-3, 60.0);
  deadband.begin(milliseconds(80));
  const auto at = [](int ms) { return Deadband::TimePoint(milliseconds(ms)); };
  ASSERT_TRUE(deadband.is_news(1, Proxy::free(), {}, at(0)));
  deadband.used(1);
  Proxy proxy = Proxy::free();
  proxy.valid_for = milliseconds(40);
  EXPECT_FALSE(deadband.is_news(2, proxy, {}, at(20))) << "sample 1 lasts for 80 ms";
  ASSERT_TRUE(deadband.is_news(2, proxy, {}, at(60)));
  deadband.used(2);
  EXPECT_FALSE(deadband.is_news(3, Proxy::free(), {}, at(70)));
  EXPECT_TRUE(deadband.is_news(3, Proxy::free(), {}, at(80))) << "sample 2 lasts for 40 ms";
}

TEST(Deadband, NewStreamKnowsNothing) {
  Deadband deadband({}, 1e-3, 60.0);
  deadband.begin(milliseconds(80));
  ASSERT_TRUE(deadband.is_news(1, Proxy::free(), {}, {}));
  deadband.used(1);
  deadband.begin(milliseconds(80));
  EXPECT_TRUE(deadband.is_news(2, Proxy::free(), {}, {}));
}

/// A wall at `surface` that the client tells at 60 Hz, and a server behind 50 ms each way.
struct Told {
  std::uint64_t seq{0};
  double surface{0.0}, sent_s{0.0};
};

TEST(Deadband, OldLawEndsWithNextSample) {
  constexpr double kWidth = 1e-3, kPeriod = 1.0 / 60.0, kWay = 0.050, kFresh = 2.5 * kPeriod;
  for (const double lost : {0.0, 0.1, 0.5}) {
    std::mt19937 random(7);
    const auto uniform = [&] { return std::uniform_real_distribution<double>()(random); };
    Deadband deadband({{"x", "m", "linear"}}, kWidth, 60.0);
    deadband.begin(ns(kFresh));
    std::vector<Told> all{{}};  // by number
    std::vector<bool> came{false};
    std::uint64_t seq = 0;
    double surface = 0.5;
    int withheld = 0;
    for (int k = 0; k < 20000; ++k) {
      const double now = k * kPeriod;
      if (uniform() < 0.1) surface += 4e-3 * (uniform() - 0.5);
      // The state that is here left a way ago, and names what had come by then.
      for (std::uint64_t i = seq; i > 0; --i) {
        if (!came[i] || all[i].sent_s + 2.0 * kWay > now) continue;
        deadband.used(i);
        break;
      }
      const double x = std::min(surface, 0.6);
      const Proxy proxy = Proxy::behind({{.normal = {1.0}, .offset = surface, .id = 1}}, {x});
      if (deadband.is_news(seq + 1, proxy, {0.6}, Deadband::TimePoint(ns(now)))) {
        ++seq;
        all.push_back({seq, surface, now});
        came.push_back(uniform() >= lost);
        continue;
      }
      ++withheld;
      // Whatever the server uses from the arrival of this one on, it is what this one says, and
      // something was sent so lately that the next one comes in time.
      std::uint64_t in_use = seq;
      while (in_use > 0 && !came[in_use]) --in_use;
      ASSERT_NEAR(all[in_use].surface, surface, kWidth) << k;
      ASSERT_LE(now + kPeriod - all[seq].sent_s, kFresh) << k;
    }
    EXPECT_GT(withheld, lost > 0.2 ? 1000 : 5000);
  }
}

}  // namespace
}  // namespace haptic::client
