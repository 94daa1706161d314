// What the timer's patience means, by numbers that follow from its definition: a link without jitter
// makes every tick predictable. The table in server/README.md comes from the same study.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>

#include "tests/bench/patience_study.hpp"

namespace {

using namespace std::chrono_literals;
using haptic::bench::PatienceRow;
using haptic::bench::SampleLink;
using haptic::bench::study_patience;
using haptic::core::Duration;

constexpr double kUs = 1.0;
constexpr double kCrystal = 0.1;  // us that a period of a crystal 50 ppm away is longer, and more
constexpr Duration kPatiences[] = {125us, 250us, 500us};

double us(Duration d) {
  return static_cast<double>(d.count()) * 1e-3;
}

TEST(Patience, APunctualLinksSamplesAreUsedAtTheirArrivalWhateverItIs) {
  for (const Duration patience : kPatiences) {
    const PatienceRow row = study_patience({"punctual"}, patience);
    EXPECT_NEAR(row.age_p50_us, 60.0, 0.01 * kUs);
    EXPECT_NEAR(row.age_p99_us, 60.0, 0.01 * kUs);
    EXPECT_LT(row.by_timer_percent, 0.01);
    EXPECT_NEAR(row.gap_at_silence_us, 1000.0 + us(patience), kCrystal);
  }
}

TEST(Patience, ByTheTimerAloneASampleIsOfAnyAgeUpToAPeriod) {
  const PatienceRow row = study_patience({"punctual"}, std::nullopt);
  EXPECT_NEAR(row.age_p50_us, 60.0 + 500.0, 40.0);
  EXPECT_NEAR(row.age_p99_us, 60.0 + 990.0, 40.0);
  EXPECT_EQ(row.by_timer_percent, 100.0);
  EXPECT_NEAR(row.longest_gap_us, 1000.0, kCrystal);
  EXPECT_NEAR(row.gap_at_silence_us, 1000.0, kCrystal);
}

TEST(Patience, ALostSampleIsOneTickOfTheTimersWithASampleAPeriodAndThePatienceOld) {
  SampleLink link{"loses 5 %"};
  link.lost = 0.05;
  for (const Duration patience : kPatiences) {
    const PatienceRow row = study_patience(link, patience);
    EXPECT_NEAR(row.by_timer_percent, 5.0, 0.3);  // 160 000 samples: 5 sigma are 0.27
    EXPECT_NEAR(row.age_p50_us, 60.0, kCrystal);
    EXPECT_NEAR(row.age_p99_us, 60.0 + 1000.0 + us(patience), kCrystal);
    EXPECT_NEAR(row.shortest_gap_us, 1000.0 - us(patience), 10 * kCrystal);
  }
}

TEST(Patience, ALinkOfHalfTheRateHasEveryOtherTickByTheTimer) {
  SampleLink link{"pairs"};
  link.frame = 2ms;
  for (const Duration patience : kPatiences) {
    const PatienceRow row = study_patience(link, patience);
    EXPECT_NEAR(row.by_timer_percent, 50.0, 0.1);
    EXPECT_GE(row.shortest_gap_us, 1000.0 - us(patience) - kCrystal);
    EXPECT_LE(row.longest_gap_us, 1000.0 + us(patience) + kCrystal);
  }
}

TEST(Patience, NoTickIsFurtherFromTheLastThanAPeriodAndThePatienceWhateverTheLinkDoes) {
  SampleLink link{"bad"};
  link.jitter = 300us;
  link.lost = 0.05;
  link.held_up = 0.02;
  double by_timer = 100.0;
  for (const Duration patience : kPatiences) {
    const PatienceRow row = study_patience(link, patience);
    EXPECT_LE(row.longest_gap_us, 1000.0 + us(patience) + kUs);
    EXPECT_GE(row.shortest_gap_us, 1000.0 - us(patience) - kUs);
    EXPECT_LT(row.by_timer_percent, by_timer) << "who waits longer gets more samples";
    by_timer = row.by_timer_percent;
  }
}

TEST(Patience, TheTableInTheReadmeIsWhatTheStudyGives) {
  std::ifstream page(HAPTIC_SOURCE_DIR "/server/README.md");
  const std::string text{std::istreambuf_iterator<char>(page), {}};
  for (const SampleLink& link : haptic::bench::usual_links()) {
    const PatienceRow timer = study_patience(link, std::nullopt);
    char piece[64];
    std::snprintf(piece, sizeof piece, "%.0f / %.0f |", timer.age_p50_us, timer.age_p99_us);
    std::string row = "| " + link.name + " | " + piece;
    for (const Duration patience : kPatiences) {
      const PatienceRow paced = study_patience(link, patience);
      std::snprintf(piece, sizeof piece, " %.0f / %.0f, %.1f %% |", paced.age_p50_us,
                    paced.age_p99_us, paced.by_timer_percent);
      row += piece;
    }
    EXPECT_NE(text.find(row), std::string::npos) << row;
  }
}

TEST(Patience, TheSameRunsGiveTheSameFigures) {
  SampleLink link{"jittery"};
  link.jitter = 100us;
  const PatienceRow one = study_patience(link, 250us, 4, 1s);
  const PatienceRow two = study_patience(link, 250us, 4, 1s);
  EXPECT_EQ(one.age_p99_us, two.age_p99_us);
  EXPECT_EQ(one.by_timer_percent, two.by_timer_percent);
}

}  // namespace
