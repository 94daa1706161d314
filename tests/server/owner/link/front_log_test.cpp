#include "server/owner/link/front_log.hpp"

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <sstream>

namespace haptic::server {
namespace {

using namespace std::chrono_literals;
using core::TimePoint;

class FrontLogTest : public testing::Test {
 protected:
  FrontLogTest() {
    auto [here, there] = packet_pair();
    front_ = std::move(there);
    log_ = std::make_unique<FrontLog>(std::move(here));
    auto logger = std::make_shared<spdlog::logger>(
        "test", std::make_shared<spdlog::sinks::ostream_sink_st>(text_));
    logger->set_pattern("%l %v");
    spdlog::set_default_logger(logger);
  }
  ~FrontLogTest() override { spdlog::set_default_logger(before_); }
  bool say(const std::string& words) {
    return send_bytes(front_.get(), std::as_bytes(std::span(words)));
  }
  /// All that was logged at `now`.
  std::string logged(TimePoint now) {
    EXPECT_TRUE(log_->copy(now));
    return std::exchange(text_, std::ostringstream()).str();
  }

  const std::shared_ptr<spdlog::logger> before_{spdlog::default_logger()};
  std::ostringstream text_{};
  Descriptor front_{};
  std::unique_ptr<FrontLog> log_{};
};

TEST_F(FrontLogTest, LinesKeepTheirLevels) {
  ASSERT_TRUE(say("<6>serving\n<3>no"));
  EXPECT_EQ(logged(TimePoint(1s)), "info front: serving\n");
  ASSERT_TRUE(say("t at all\nterminate called\n"));
  EXPECT_EQ(logged(TimePoint(1s)), "error front: not at all\nwarning front: terminate called\n");
}

TEST_F(FrontLogTest, LastWordsAreKept) {
  ASSERT_TRUE(say("<2>dead"));
  EXPECT_EQ(logged(TimePoint(1s)), "");
  log_.reset();
  EXPECT_EQ(text_.str(), "critical front: dead\n");
}

TEST_F(FrontLogTest, AFloodIsBounded) {
  std::size_t bytes = 0;
  for (int ms = 0; ms < 10'000; ms += 50) {
    while (say(std::string(1000, '\n') + "x\n") && say(std::string(3000, 'x'))) continue;
    bytes += logged(TimePoint(1s) + ms * 1ms).size();
  }
  EXPECT_LT(static_cast<double>(bytes), 11 * FrontLog::kBytesPerSecond + FrontLog::kAtOnce);
  EXPECT_EQ(log_->descriptor(), -1) << "nothing to wake up for";
}

TEST_F(FrontLogTest, ShortMessagesCount) {
  int messages = 0;
  for (int i = 0; i < 100; ++i) {
    while (say("x")) ++messages;
    static_cast<void>(logged(TimePoint(1s)));
  }
  EXPECT_LT(messages * FrontLog::kPerLine, 2 * FrontLog::kAtOnce) << "they take the thread's time";
}

TEST_F(FrontLogTest, AClosedEndWakesNobody) {
  front_ = Descriptor();
  EXPECT_EQ(logged(TimePoint(1s)), "");
  EXPECT_EQ(log_->descriptor(), -1);
}

TEST_F(FrontLogTest, DescriptorsEndTheFront) {
  const int one = front_.get();
  ASSERT_TRUE(send(front_.get(), 'x', std::span(&one, 1)));
  EXPECT_FALSE(log_->copy(TimePoint(1s)));
  EXPECT_EQ(log_->descriptor(), -1);
}

}  // namespace
}  // namespace haptic::server
