#include "haptic/wire/path_end.hpp"

#include <gtest/gtest.h>

#include <deque>

#include "tests/proto/wire/channel_pair.hpp"

namespace haptic::wire {
namespace {

using namespace std::chrono_literals;
using test::bytes_of;
using test::ByteVector;
using test::test_keys;

PeerAddress port_only(std::uint16_t port) {
  PeerAddress answer;
  answer.port = port;
  return answer;
}

/// Two ends joined by a wire without length; everything that passed is kept.
struct Joined {
  struct Datagram {
    PeerAddress from{}, to{};
    ByteVector bytes{};
  };

  /// If `in_use_for` is above 0, the client started so long ago.
  explicit Joined(Duration in_use_for = {})
      : client(setup(End::kClient, client_address)), server(setup(End::kServer, server_address)) {
    if (in_use_for > Duration(0)) client.start(server_address, now);
    run(in_use_for);
  }

  PathEndSetup setup(End which, const PeerAddress& own) {
    PathEndSetup setup;
    setup.end = which;
    setup.keys = test_keys(1);
    setup.send = [this, &own](const PeerAddress& to, ConstBytes bytes) {
      under_way.push_back({own, to, {bytes.begin(), bytes.end()}});
    };
    return setup;
  }

  void run(Duration duration) {
    for (const TimePoint end = now + duration; now < end; now += 1ms) {
      client.step(now);
      server.step(now);
      flush();
    }
  }
  void flush() {
    while (!under_way.empty()) {
      const Datagram datagram = under_way.front();
      under_way.pop_front();
      if (cut) continue;
      passed.push_back(datagram);
      const bool up = datagram.to == server_address;
      if (!up && !(datagram.to == client_address)) continue;  // to an address where nobody is
      const Received received = (up ? server : client).receive(datagram.bytes, datagram.from, now);
      if (received.message) {
        (up ? at_server : at_client)
            .emplace_back(received.message->begin(), received.message->end());
      }
    }
  }
  /// The datagram that was sent last; nothing under way arrives.
  ByteVector intercept() {
    const ByteVector last = under_way.back().bytes;
    under_way.clear();
    return last;
  }
  std::size_t sent_to(const PeerAddress& to) const {
    return static_cast<std::size_t>(
        std::count_if(passed.begin(), passed.end(), [&](const Datagram& d) { return d.to == to; }));
  }

  TimePoint now{100s};
  bool cut{false};
  PeerAddress client_address{port_only(1)}, server_address{port_only(2)};
  std::deque<Datagram> under_way{}, passed{};
  std::vector<std::string> at_server{}, at_client{};
  PathEnd client, server;
};

TEST(PathEnd, SendsNoMessageBeforeUse) {
  Joined pair;
  EXPECT_FALSE(pair.client.send(bytes_of("a")));
  pair.run(100ms);
  EXPECT_TRUE(pair.passed.empty()) << "the client begins";
  pair.client.start(pair.server_address, pair.now);
  pair.run(10ms);
  EXPECT_FALSE(pair.client.send(bytes_of("a")));
  EXPECT_FALSE(pair.server.send(bytes_of("a")));
  pair.run(90ms);
  EXPECT_TRUE(pair.client.send(bytes_of("up")));
  EXPECT_TRUE(pair.server.send(bytes_of("down")));
  EXPECT_EQ(pair.server.address(), pair.client_address);
  EXPECT_FALSE(pair.client.send(ByteVector(kLargestPayload + 1)));
  pair.flush();
  EXPECT_EQ(pair.at_server, std::vector<std::string>{"up"});
  EXPECT_EQ(pair.at_client, std::vector<std::string>{"down"});
}

TEST(PathEnd, NeverAnswersAFailedDatagram) {
  Joined pair;
  pair.client.start(pair.server_address, pair.now);
  pair.client.step(pair.now);
  ASSERT_FALSE(pair.under_way.empty());
  const ByteVector challenge = pair.intercept();
  for (std::size_t at = 0; at < challenge.size(); ++at) {
    ByteVector bad = challenge;
    bad[at] ^= 0x80U;
    EXPECT_NE(pair.server.receive(bad, port_only(66), pair.now).rejection, Rejection::kNone);
  }
  pair.server.step(pair.now + 1s);
  EXPECT_TRUE(pair.under_way.empty());
  EXPECT_EQ(pair.server.state(), PathState::kOff);
}

TEST(PathEnd, ResponseMatchesItsChallengesLength) {
  Joined pair(1s);
  for (const auto& datagram : pair.passed) {
    const auto type = read_header(datagram.bytes).header.type;
    if (type == DatagramType::kPathChallenge || type == DatagramType::kPathResponse) {
      EXPECT_TRUE(datagram.bytes.size() == 1200 || datagram.bytes.size() == 72);
    }
  }
}

TEST(PathEnd, StatesFollowAfterTheAddressAnswers) {
  Joined pair(200ms);
  pair.client_address = port_only(9);
  EXPECT_TRUE(pair.client.send(bytes_of("from elsewhere")));
  pair.flush();
  EXPECT_EQ(pair.at_server.size(), 1U);  // the sample is genuine, wherever it came from
  EXPECT_EQ(pair.server.address(), port_only(1));
  pair.run(100ms);
  EXPECT_EQ(pair.server.address(), port_only(9));
}

TEST(PathEnd, SpoofedSourceGetsNoState) {
  Joined pair(200ms);
  const PeerAddress victim = port_only(66);
  // A genuine datagram, caught on its way and sent on under the victim's name.
  EXPECT_TRUE(pair.client.send(bytes_of("caught")));
  const ByteVector caught = pair.intercept();
  EXPECT_EQ(pair.server.receive(caught, victim, pair.now).rejection, Rejection::kNone);
  EXPECT_EQ(pair.server.receive(caught, victim, pair.now).rejection, Rejection::kDuplicate);
  for (int i = 0; i < 200; ++i) {
    EXPECT_TRUE(pair.server.send(bytes_of("state")));
    pair.run(1ms);
  }
  EXPECT_EQ(pair.sent_to(victim), 5U);
  EXPECT_EQ(pair.at_client.size(), 200U);
  EXPECT_EQ(pair.server.address(), pair.client_address);
}

TEST(PathEnd, RekeyInterruptsNothing) {
  Joined pair(2s);
  pair.server.rekey(test_keys(2));
  pair.run(100ms);
  pair.client.rekey(test_keys(2));
  for (int i = 0; i < 2000; ++i) {
    EXPECT_TRUE(pair.client.send(bytes_of("up")));
    EXPECT_TRUE(pair.server.send(bytes_of("down")));
    pair.run(1ms);
  }
  EXPECT_EQ(pair.at_server.size(), 2000U);
  EXPECT_EQ(pair.at_client.size(), 2000U);
  for (PathEnd* end : {&pair.client, &pair.server}) {
    EXPECT_TRUE(end->in_use());
    EXPECT_EQ(end->counters().lost, 0U);
    for (const std::uint64_t rejected : end->counters().rejected) EXPECT_EQ(rejected, 0U);
  }
}

TEST(PathEnd, DatagramAfterCloseBeginsNothing) {
  Joined pair(200ms);
  ASSERT_TRUE(pair.client.send(bytes_of("late")));
  const ByteVector late = pair.intercept();
  pair.client.close();
  pair.flush();
  ASSERT_EQ(pair.server.state(), PathState::kOff);
  EXPECT_EQ(pair.server.receive(late, pair.client_address, pair.now).rejection, Rejection::kNone);
  EXPECT_EQ(pair.server.state(), PathState::kOff);
  pair.client.start(pair.server_address, pair.now);  // what comes after it does
  pair.run(100ms);
  EXPECT_EQ(pair.server.state(), PathState::kOff);  // twice in half a second is too often
  pair.run(900ms);
  EXPECT_EQ(pair.server.state(), PathState::kInUse);
}

TEST(PathEnd, CutsAnExcessiveReport) {
  Joined pair(200ms);
  test::TestEnd liar(End::kClient, test_keys(2));
  pair.server.rekey(test_keys(2));
  const ByteVector first = liar.seal(DatagramType::kProxy, "the server changes to the new keys");
  static_cast<void>(pair.server.receive(first, pair.client_address, pair.now));
  static_cast<void>(pair.server.step(pair.now + 20ms));  // a challenge under the new keys
  ASSERT_FALSE(pair.under_way.empty());
  test::TestEnd reader(End::kClient, test_keys(2));
  const std::string challenge = reader.open(pair.under_way.back().bytes, pair.now);
  ByteVector response(challenge.size());
  ASSERT_GE(response.size(), 40U);
  const auto token = read_challenge(bytes_of(challenge));
  ASSERT_TRUE(token);
  // 1000 datagrams, the newest of them 2^63: one was sent under these keys, the challenge itself.
  write(PathResponse{token->token, 0, 0, 1000, std::uint64_t{1} << 63U}, response);
  const ByteVector lie = liar.seal(DatagramType::kPathResponse, {response.begin(), response.end()});
  ASSERT_EQ(pair.server.receive(lie, pair.client_address, pair.now + 21ms).rejection,
            Rejection::kNone);
  EXPECT_EQ(pair.server.peer_report().newest, 1U);
  EXPECT_EQ(pair.server.peer_report().received, 1U);
}

TEST(PathEnd, ShortChallengeIsCountedNotAnswered) {
  Joined pair;
  test::TestEnd client(End::kClient, test_keys(1));
  const ByteVector shortened = client.seal(DatagramType::kPathChallenge, "12345678");
  EXPECT_EQ(pair.server.receive(shortened, pair.client_address, pair.now).rejection,
            Rejection::kPayload);
  EXPECT_TRUE(pair.under_way.empty());
  EXPECT_EQ(pair.server.counters().rejections(Rejection::kPayload), 1U);
}

TEST(PathEnd, MeasuresRoundTripAndOtherClock) {
  Joined pair(1s);
  ASSERT_TRUE(pair.client.round_trip().known());
  EXPECT_EQ(pair.client.round_trip().smoothed(), 0ns);
  ASSERT_TRUE(pair.client.clock_offset().at(pair.now));
  EXPECT_EQ(pair.client.clock_offset().at(pair.now)->offset, 0ns);
}

}  // namespace
}  // namespace haptic::wire
