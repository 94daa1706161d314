// When a stream's status may leave: after everything that the session held was given up, and once.
// The carrier is played by hand, so that a write completes exactly where a test wants it to.
#include "server/front/service/response_stream.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <utility>

#include "tests/server/support/device_rig.hpp"

namespace haptic::test {
namespace {

using server::Refusal;

const Refusal kFirst{Refusal::Code::kUnavailable, "FIRST", "the first end's"};

/// It is done before finish() returns, which a carrier may be.
class HandDrivenStream final : public server::ResponseStream {
 public:
  using ResponseStream::end;
  using ResponseStream::Ending;
  using ResponseStream::lost;
  using ResponseStream::ResponseStream;
  using ResponseStream::written;

  /// Holds what an open session holds: a place in the broadcast, and the lease of `name`.
  void open(HandFront& front, const std::string& name, server::Broadcaster& broadcaster,
            std::uint32_t grant) {
    self_ = shared_from_this();
    front_ = &front;
    name_ = name;
    join(broadcaster, grant);
  }
  void begin_write() {
    const std::lock_guard lock(mutex_);
    write({});
  }
  bool offer(const server::SerialisedState&, server::StateFrame&, bool) override {
    ++offered;
    return false;
  }
  int offered{0}, finishes{0};
  std::function<void()> on_finish{};
  std::optional<Refusal> why{};  ///< of the last finish()

 private:
  void write(server::Outgoing /*message*/) override { writing_ = true; }
  void finish(const std::optional<Refusal>& reason) override {
    ++finishes;
    why = reason;
    if (on_finish) on_finish();
    const auto last = std::move(self_);
  }
  void flush() override {}
  void close(Ending /*ending*/) override { front_->close(name_); }

  HandFront* front_{nullptr};
  std::string name_{};
  std::shared_ptr<ResponseStream> self_{};
};

class ResponseStreamTest : public testing::Test {
 protected:
  void SetUp() override {
    rig.owner->connect(context);
    stream = std::make_shared<HandDrivenStream>(*context);
    const server::Lease lease = rig.control(id);
    stream->open(*rig.sessions, id, *context->broadcasters.front(), lease.tenure);
    stream->on_finish = [this] { look(); };
    rig.tick();
    ASSERT_EQ(stream->offered, 1) << "it has no place in the broadcast";
    ASSERT_TRUE(rig.sessions->holds_lease(id));
  }

  /// Things that are still held when the status leaves.
  void look() {
    lease_at_finish = rig.sessions->holds_lease(id);
    id_at_finish = rig.sessions->status().sessions > 0;
    const int before = stream->offered;
    rig.tick();
    place_at_finish = stream->offered > before;
  }
  /// `act` is called in the middle of giving up: when the lease is gone, and the rest is not.
  void while_giving_up(std::function<void()> act) {
    rig.sessions->engage(id, [this, act = std::move(act)](const Outcome<Done>&) {
      ++interleaved;
      act();
    });
  }
  void end_while_a_write_completes(bool ok) {
    stream->begin_write();
    while_giving_up([this, ok] {
      stream->written(ok);
      EXPECT_EQ(stream->finishes, 0) << "the client would hear of the end too early";
    });
    stream->end(kFirst);
    EXPECT_EQ(interleaved, 1) << "nothing was interleaved: this test proves nothing";
    expect_everything_was_given_up_first();
    ASSERT_TRUE(stream->why);
    EXPECT_EQ(stream->why->reason, "FIRST");
  }
  void expect_everything_was_given_up_first() {
    EXPECT_EQ(stream->finishes, 1);
    EXPECT_FALSE(lease_at_finish);
    EXPECT_FALSE(place_at_finish);
    EXPECT_FALSE(id_at_finish);
  }

  DeviceRig rig;
  std::shared_ptr<server::ServiceContext> context = std::make_shared<server::ServiceContext>(
      server::FrontConfig{}, *rig.owner, [] { return server::ServerFacts{}; });
  const std::string id = "s1";
  std::shared_ptr<HandDrivenStream> stream;
  bool lease_at_finish{true}, place_at_finish{true}, id_at_finish{true};
  int interleaved{0};
};

TEST_F(ResponseStreamTest, EndFinishesWithoutAPendingWrite) {
  stream->end({});
  expect_everything_was_given_up_first();
}

TEST_F(ResponseStreamTest, EndWaitsForAPendingWrite) {
  stream->begin_write();
  stream->end({});
  EXPECT_EQ(stream->finishes, 0) << "a carrier allows no end during a write";
  EXPECT_EQ(rig.sessions->status().sessions, 0U) << "what was held does not wait for a slow client";
  stream->written(true);
  expect_everything_was_given_up_first();
}

TEST_F(ResponseStreamTest, CompletionDoesNotOvertakeTheEnd) {
  end_while_a_write_completes(true);
}

TEST_F(ResponseStreamTest, FailureDoesNotOvertakeTheEnd) {
  end_while_a_write_completes(false);
}

TEST_F(ResponseStreamTest, SecondEndChangesNothing) {
  stream->begin_write();
  while_giving_up([this] { stream->lost(); });
  stream->end(kFirst);
  EXPECT_EQ(interleaved, 1);
  stream->written(true);
  expect_everything_was_given_up_first();
  ASSERT_TRUE(stream->why);
  EXPECT_EQ(stream->why->reason, "FIRST");
}

TEST_F(ResponseStreamTest, FailedWriteEndsTheStream) {
  stream->begin_write();
  stream->written(false);
  expect_everything_was_given_up_first();
  EXPECT_FALSE(stream->why);
}

}  // namespace
}  // namespace haptic::test
