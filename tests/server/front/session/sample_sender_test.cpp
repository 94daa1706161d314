#include "server/front/session/sample_sender.hpp"

#include <gtest/gtest.h>

#include <map>

namespace haptic::server {
namespace {

/// An owner that does not read for a while, and then reads everything.
class SenderTest : public testing::Test {
 protected:
  SenderTest() {
    auto [here, there] = packet_pair();
    owner_ = std::move(here);
    sender_ = std::make_unique<SampleSender>(std::move(there));
  }
  void send(std::uint64_t ticket, std::uint64_t seq) {
    sender_->send(ProxySample{.ticket = ticket, .seq = seq});
  }
  /// The newest sample of each ticket, in order of arrival; a stop counts as ticket 0.
  void read() {
    auto sample = std::make_unique<ProxySample>();
    StopAhead stop;
    for (Next next; (next = look_at_next(owner_.get())).what == Received::kMessage; ++got_) {
      if (static_cast<SampleKind>(next.word) == SampleKind::kStopAhead) {
        ASSERT_TRUE(take_sample(owner_.get(), next.bytes, stop));
        ++stops_;
        continue;
      }
      ASSERT_TRUE(take_sample(owner_.get(), next.bytes, *sample));
      EXPECT_GT(sample->seq, newest_[sample->ticket]) << "never back";
      newest_[sample->ticket] = sample->seq;
    }
  }

  Descriptor owner_{};
  std::unique_ptr<SampleSender> sender_{};
  std::map<std::uint64_t, std::uint64_t> newest_{};
  int got_{0}, stops_{0};
};

TEST_F(SenderTest, TheNewestOfEachIsKept) {
  constexpr std::uint64_t kMany = 2000;
  for (std::uint64_t seq = 1; seq <= kMany; ++seq) {
    send(1, seq);
    if (seq == kMany / 2) send(2, 1);  // a flood of one sender takes no other's place
  }
  sender_->send(StopAhead{0, "hot"});
  read();
  EXPECT_LT(got_, 1000);
  sender_->flush();
  read();
  EXPECT_EQ(newest_[1], kMany);
  EXPECT_EQ(newest_[2], 1U);
  EXPECT_EQ(stops_, 1);
}

TEST_F(SenderTest, TheNextSampleTakesItAlong) {
  for (std::uint64_t seq = 1; seq <= 2000; ++seq) send(1, seq);
  sender_->send(StopAhead{0, "hot"});
  read();
  send(1, 2001);
  read();
  EXPECT_EQ(newest_[1], 2001U);
  EXPECT_EQ(stops_, 1);
}

}  // namespace
}  // namespace haptic::server
