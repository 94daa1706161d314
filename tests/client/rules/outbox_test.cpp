/// The message that a stream writes next, without a stream.

#include "outbox.hpp"

#include <gtest/gtest.h>

#include <random>

namespace haptic::client {
namespace {

Outbox::Message sample(std::uint64_t seq) {
  Outbox::Message message;
  message.mutable_proxy()->set_seq(seq);
  return message;
}

TEST(Outbox, SampleWaitsForTheWrite) {
  Outbox outbox;
  const auto* first = outbox.put(sample(1));
  ASSERT_NE(first, nullptr);
  for (std::uint64_t seq = 2; seq <= 9; ++seq) EXPECT_EQ(outbox.put(sample(seq)), nullptr);
  EXPECT_EQ(first->proxy().seq(), 1U) << "must not change while it is written";
  const Outbox::Written written = outbox.written(true);
  EXPECT_TRUE(written.sample);
  ASSERT_NE(written.next, nullptr);
  EXPECT_EQ(written.next->proxy().seq(), 9U) << "the newest wins";
  EXPECT_EQ(outbox.written(true).next, nullptr);
  EXPECT_EQ(outbox.state(), Outbox::State::kIdle);
}

TEST(Outbox, EverySampleIsSentOrReplaced) {
  Outbox outbox;
  std::mt19937 random(7);
  std::uint64_t put = 0, sent = 0, replaced = 0;
  const auto write_one = [&] {
    const Outbox::Written written = outbox.written(true);
    sent += written.sample ? 1 : 0;
    replaced += written.replaced;
  };
  for (int i = 0; i < 1000; ++i) {
    if (outbox.state() == Outbox::State::kIdle || random() % 3 != 0) {
      static_cast<void>(outbox.put(sample(++put)));
    } else {
      write_one();
    }
  }
  while (outbox.state() != Outbox::State::kIdle) write_one();
  EXPECT_EQ(sent + replaced, put);
  EXPECT_GT(replaced, 0U);
}

TEST(Outbox, TheOpeningIsNoSample) {
  Outbox outbox;
  Outbox::Message opening;
  opening.mutable_open();
  ASSERT_NE(outbox.put(opening), nullptr);
  EXPECT_FALSE(outbox.written(true).sample);
}

TEST(Outbox, FarewellReplacesWaitingMessages) {
  Outbox outbox;
  static_cast<void>(outbox.put(sample(1)));
  static_cast<void>(outbox.put(sample(2)));
  EXPECT_EQ(outbox.leave(), nullptr) << "one write at a time";
  const Outbox::Written written = outbox.written(true);
  ASSERT_NE(written.next, nullptr);
  EXPECT_TRUE(written.next->has_leave());
}

TEST(Outbox, NothingFollowsTheFarewell) {
  Outbox outbox;
  ASSERT_NE(outbox.leave(), nullptr);
  EXPECT_EQ(outbox.put(sample(1)), nullptr);
  EXPECT_EQ(outbox.leave(), nullptr);
  EXPECT_EQ(outbox.written(true).next, nullptr);
  EXPECT_EQ(outbox.state(), Outbox::State::kOver);
}

TEST(Outbox, AFailedWriteIsTheLast) {
  Outbox outbox;
  static_cast<void>(outbox.put(sample(1)));
  static_cast<void>(outbox.put(sample(2)));
  const Outbox::Written written = outbox.written(false);
  EXPECT_FALSE(written.sample);
  EXPECT_EQ(written.next, nullptr);
  EXPECT_EQ(outbox.put(sample(3)), nullptr);
}

}  // namespace
}  // namespace haptic::client
