#include "server/crossing/broadcast.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <memory>
#include <thread>

#include "server/crossing/crossing.hpp"

namespace {

using haptic::server::Broadcast;
using haptic::server::Latest;
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

}  // namespace
