#include "server/crossing/broadcast.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <memory>
#include <thread>
#include <vector>

#include "server/crossing/crossing.hpp"
#include "server/crossing/inbox.hpp"

namespace {

using haptic::server::Broadcast;
using haptic::server::Inbox;
using haptic::server::Latest;
using haptic::server::PlaneSample;
using haptic::server::ProxySample;
using haptic::server::SerialisedState;

/// A value whose every word says the same, so that a mixture of two shows.
struct Words {
  std::array<std::uint64_t, 40> word{};
  static Words of(std::uint64_t number) {
    Words words;
    words.word.fill(number);
    return words;
  }
  [[nodiscard]] bool whole() const {
    for (const std::uint64_t each : word) {
      if (each != word[0]) return false;
    }
    return true;
  }
};

/// Zeroed, as shared memory is.
template <typename T>
std::unique_ptr<T> zeroed() {
  auto made = std::make_unique<T>();
  std::memset(static_cast<void*>(made.get()), 0, sizeof(T));
  return made;
}

using Ring = Broadcast<Words, 8>;

TEST(Broadcast, ReaderGetsEveryValueInOrder) {
  const auto ring = zeroed<Ring>();
  Ring::Cursor cursor = ring->begin(0);
  Words words;
  EXPECT_FALSE(ring->read(cursor, words));
  for (std::uint64_t i = 1; i <= 20; ++i) {
    ring->publish(Words::of(i));
    ASSERT_TRUE(ring->read(cursor, words));
    EXPECT_EQ(words.word[0], i);
    EXPECT_FALSE(ring->read(cursor, words));
  }
}

TEST(Broadcast, ASlowReaderGetsTheNewest) {
  const auto ring = zeroed<Ring>();
  Ring::Cursor cursor = ring->begin(0);
  for (std::uint64_t i = 0; i < 20; ++i) ring->publish(Words::of(i));
  Words words;
  std::uint64_t got = 0;
  while (ring->read(cursor, words)) ++got;
  EXPECT_EQ(words.word[0], 19U);
  EXPECT_EQ(got, Ring::kKept - 1);
}

TEST(Broadcast, NewReaderBeginsInThePast) {
  const auto ring = zeroed<Ring>();
  for (std::uint64_t i = 0; i < 5; ++i) ring->publish(Words::of(i));
  Ring::Cursor three = ring->begin(3);
  Words words;
  ASSERT_TRUE(ring->read(three, words));
  EXPECT_EQ(words.word[0], 2U);
  EXPECT_EQ(ring->begin(100).next, 0U);
}

TEST(Broadcast, NoReaderGetsAMixture) {
  const auto ring = zeroed<Ring>();
  const auto latest = zeroed<Latest<Words>>();
  constexpr std::uint64_t kValues = 200'000;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kValues; ++i) {
      ring->publish(Words::of(i));
      latest->publish(Words::of(i));
    }
  });
  Ring::Cursor cursor = ring->begin(0);
  Words words;
  std::uint64_t last = 0;
  while (last < kValues) {
    ASSERT_TRUE(latest->value().whole());
    if (!ring->read(cursor, words)) continue;
    ASSERT_TRUE(words.whole());
    ASSERT_GT(words.word[0], last);
    last = words.word[0];
  }
  writer.join();
}

TEST(Latest, GivesTheFallbackBeforeTheFirst) {
  const auto latest = zeroed<Latest<Words>>();
  EXPECT_EQ(latest->value(Words::of(7)).word[3], 7U);
  latest->publish(Words::of(9));
  EXPECT_EQ(latest->value(Words::of(7)).word[3], 9U);
}

TEST(Latest, TellsWhatIsNew) {
  const auto latest = zeroed<Latest<Words>>();
  std::uint64_t seen = 0;
  Words words;
  EXPECT_FALSE(latest->newer(seen, words));
  latest->publish(Words::of(1));
  latest->publish(Words::of(2));
  EXPECT_TRUE(latest->newer(seen, words));
  EXPECT_EQ(words.word[0], 2U);
  EXPECT_FALSE(latest->newer(seen, words));
  latest->publish(Words::of(3));
  EXPECT_TRUE(latest->newer(seen, words));
}

TEST(Latest, CopiesTheBytesInUse) {
  const auto latest = zeroed<Latest<SerialisedState>>();
  SerialisedState state, got;
  state.bytes.fill(7);
  got.bytes.fill(1);
  state.size = 16;
  latest->publish(state);
  std::uint64_t seen = 0;
  ASSERT_TRUE(latest->newer(seen, got));
  EXPECT_EQ(got.message().size(), 16U);
  EXPECT_EQ(got.bytes[15], 7);
  EXPECT_EQ(got.bytes[24], 1) << "behind the message nothing is copied";
  state.size = ~0U;
  latest->publish(state);
  ASSERT_TRUE(latest->newer(seen, got));
  EXPECT_EQ(got.message().size(), SerialisedState::kMost) << "a size that lies stays within";
}

using Box = Inbox<std::uint64_t, 8>;

TEST(Inbox, GivesTheNewestOfFastWriter) {
  const auto box = zeroed<Box>();
  Box::Cursor cursor;
  for (std::uint64_t i = 0; i < 20; ++i) box->push(i);
  std::vector<std::uint64_t> got;
  std::uint64_t value = 0;
  while (box->take(cursor, value)) got.push_back(value);
  EXPECT_EQ(got, (std::vector<std::uint64_t>{12, 13, 14, 15, 16, 17, 18, 19}));
}

TEST(Inbox, ALyingWriterEndsTheReading) {
  const auto box = zeroed<Box>();
  // The number of values lies at the beginning: a hostile front writes what it likes there.
  auto* const head = reinterpret_cast<std::atomic<std::uint64_t>*>(box.get());
  Box::Cursor cursor;
  std::uint64_t value = 0;
  for (const std::uint64_t lie : {~std::uint64_t{0}, std::uint64_t{3}, std::uint64_t{1} << 63,
                                  std::uint64_t{0}, std::uint64_t{7}, ~std::uint64_t{0} - 3}) {
    head->store(lie);
    std::size_t got = 0;
    while (box->take(cursor, value)) ++got;
    EXPECT_LE(got, Box::kSlots) << lie;
    EXPECT_FALSE(box->take(cursor, value)) << lie;
  }
}

TEST(Inbox, CopiesThePlanesThatCount) {
  const auto box = zeroed<Inbox<ProxySample, 2>>();
  Inbox<ProxySample, 2>::Cursor cursor;
  auto sample = std::make_unique<ProxySample>(), got = std::make_unique<ProxySample>();
  for (const std::uint32_t count : {2U, 0U, 32U, 33U, ~0U}) {
    sample->plane_count = count;
    for (PlaneSample& plane : sample->planes) plane.offset = count;
    for (PlaneSample& plane : got->planes) plane.offset = -1.0;
    box->push(*sample);
    ASSERT_TRUE(box->take(cursor, *got));
    EXPECT_EQ(got->plane_count, count);
    for (std::uint32_t i = 0; i < got->planes.size(); ++i) {
      EXPECT_EQ(got->planes[i].offset, i < count ? count : -1.0) << count;
    }
  }
}

}  // namespace
