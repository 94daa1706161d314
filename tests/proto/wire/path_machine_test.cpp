#include "haptic/wire/path_machine.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>

namespace haptic::wire {
namespace {

using namespace std::chrono_literals;

PeerAddress address(std::uint16_t port) {
  PeerAddress answer;
  answer.ip[15] = 1;
  answer.port = port;
  return answer;
}

const PeerAddress kServer = address(5000), kElsewhere = address(6000);

/// A machine and the far end of its path: which answers after `rtt`, or not, as the test says.
struct Rig {
  explicit Rig(PathRules rules = {})
      : machine(rules, [tokens = std::uint64_t{0}]() mutable { return ++tokens; }) {}

  /// Millisecond by millisecond; what changed, in order.
  std::vector<PathChange> run(Duration duration) {
    std::vector<PathChange> changes;
    const auto note = [&](PathChange change) {
      if (change != PathChange::kNone) changes.push_back(change);
    };
    for (const TimePoint end = now + duration; now < end; now += 1ms) {
      while (!answers.empty() && answers.front().at <= now) {
        const Answer answer = answers.front();
        answers.pop_front();
        note(machine.responded(answer.from, answer.response, now));
      }
      note(machine.step(now));
      while (const auto challenge = machine.due(now)) send(*challenge);
      packets_sent += packets_per_ms;
    }
    return changes;
  }

  void send(const DueChallenge& challenge) {
    sent.push_back({now, challenge});
    ++challenges;
    if (lost && lost(challenges, challenge)) return;
    PathResponse response{challenge.token};
    response.newest = packets_sent;
    response.packets = static_cast<std::uint64_t>(static_cast<double>(packets_sent) * delivered);
    const Answer answer{now + (rtt_of ? rtt_of(challenges) : rtt),
                        answers_from.value_or(challenge.to), response};
    const auto later = std::find_if(answers.begin(), answers.end(),
                                    [&](const Answer& other) { return other.at > answer.at; });
    answers.insert(later, answer);
  }

  struct Sent {
    TimePoint at{};
    DueChallenge challenge{};
  };
  struct Answer {
    TimePoint at{};
    PeerAddress from{};
    PathResponse response{};
  };
  TimePoint now{100s};
  Duration rtt{10ms};
  std::function<Duration(int number)> rtt_of{};  ///< in place of rtt
  int challenges{0};
  std::function<bool(int number, const DueChallenge&)> lost{};
  std::optional<PeerAddress> answers_from{};
  std::uint64_t packets_sent{0}, packets_per_ms{1};
  double delivered{1.0};
  std::deque<Answer> answers{};
  std::vector<Sent> sent{};
  PathMachine machine;
};

using Changes = std::vector<PathChange>;

bool always(int /*number*/, const DueChallenge& /*challenge*/) {
  return true;
}

/// It begins with the next run().
Rig started() {
  Rig rig;
  rig.machine.start(kServer, rig.now);
  return rig;
}

Rig rig_in_use(Duration since = 100ms) {
  Rig rig = started();
  static_cast<void>(rig.run(since));
  EXPECT_TRUE(rig.machine.in_use());
  return rig;
}

/// Its challenges get no answer.
Rig unanswered_rig() {
  Rig rig = started();
  rig.lost = always;
  return rig;
}

TEST(PathMachine, IsSilentBeforeItIsStarted) {
  Rig rig;
  EXPECT_EQ(rig.run(1s), Changes{});
  EXPECT_TRUE(rig.sent.empty());
  EXPECT_EQ(rig.machine.state(), PathState::kOff);
  EXPECT_EQ(rig.machine.next_step(), TimePoint::max());
}

TEST(PathMachine, NeedsFourAnsweredChallenges) {
  Rig rig = started();
  EXPECT_EQ(rig.run(70ms), Changes{});  // sent at 0, 20, 40, 60; answered 10 ms later
  EXPECT_EQ(rig.machine.state(), PathState::kProbing);
  EXPECT_FALSE(rig.machine.in_use());
  EXPECT_EQ(rig.run(1ms), Changes{PathChange::kUp});
  EXPECT_TRUE(rig.machine.in_use());
  EXPECT_EQ(rig.machine.address(), kServer);
  EXPECT_EQ(rig.machine.round_trip().least(), 10ms);
}

TEST(PathMachine, ChallengesFillTheLargestDatagram) {
  Rig rig = unanswered_rig();
  static_cast<void>(rig.run(400ms));
  ASSERT_EQ(rig.sent.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(rig.sent[i].challenge.size + kHeaderSize + kTagSize, kLargestDatagram);
    EXPECT_EQ(rig.sent[i].at - rig.sent[0].at, static_cast<int>(i) * 20ms);
  }
}

TEST(PathMachine, ForgivesOneLostChallengeNotTwo) {
  for (const int losses : {0, 1, 2, 3}) {
    Rig rig = started();
    rig.lost = [losses](int number, const DueChallenge&) { return number <= losses; };
    const Changes changes = rig.run(600ms);
    EXPECT_EQ(changes, Changes{losses <= 1 ? PathChange::kUp : PathChange::kRefused}) << losses;
  }
}

TEST(PathMachine, OverdueAnswerCausesDoubt) {
  Rig rig = rig_in_use(1s);
  EXPECT_FALSE(rig.machine.in_doubt());
  EXPECT_LT(rig.machine.doubt_limit(), 42ms);  // the round trip is 10 ms and does not vary
  EXPECT_GE(rig.machine.doubt_limit(), 40ms);
  rig.lost = always;
  const TimePoint cut = rig.now;
  while (!rig.machine.in_doubt()) ASSERT_EQ(rig.run(1ms), Changes{});
  EXPECT_LE(rig.now - cut, 60ms);  // up to 10 ms to the next challenge, 10 ms for answers under way
  EXPECT_TRUE(rig.machine.in_use());
  EXPECT_LT(rig.machine.next_step(), rig.now + 10ms);
  rig.lost = {};
  while (rig.machine.in_doubt()) ASSERT_EQ(rig.run(1ms), Changes{});
  EXPECT_LT(rig.now - cut, 85ms);
  rig.lost = always;
  EXPECT_EQ(rig.run(300ms), Changes{PathChange::kSilent});
  EXPECT_FALSE(rig.machine.in_doubt());
}

TEST(PathMachine, VaryingRoundTripCausesNoDoubt) {
  Rig rig = started();
  // Five answers after 10 ms, five after 80 ms, again and again: beyond a smoothed one and 30 ms.
  rig.rtt_of = [](int number) { return number / 5 % 2 == 0 ? Duration(10ms) : Duration(80ms); };
  static_cast<void>(rig.run(1s));
  int doubts = 0;
  for (int i = 0; i < 5000; ++i) {
    ASSERT_EQ(rig.run(1ms), Changes{});
    doubts += rig.machine.in_doubt() ? 1 : 0;
    ASSERT_GT(rig.machine.round_trip().variation(), 5ms);
  }
  EXPECT_TRUE(rig.machine.in_use());
  EXPECT_EQ(doubts, 0);
}

TEST(PathMachine, ARepeatedAnswerCountsOnce) {
  Rig rig = started();
  rig.lost = [](int number, const DueChallenge&) { return number > 1; };
  static_cast<void>(rig.run(1ms));
  const Rig::Answer answer = rig.answers.front();
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(rig.machine.responded(answer.from, answer.response, rig.now), PathChange::kNone);
  }
  EXPECT_EQ(rig.run(600ms), Changes{PathChange::kRefused});
}

TEST(PathMachine, ForeignOrUnaskedAnswerProvesNothing) {
  Rig rig = started();
  rig.answers_from = kElsewhere;
  EXPECT_EQ(rig.run(600ms), Changes{PathChange::kRefused});
  Rig guessing = unanswered_rig();
  static_cast<void>(guessing.run(10ms));
  for (std::uint64_t token = 1000; token < 1010; ++token) {
    EXPECT_EQ(guessing.machine.responded(kServer, {token}, guessing.now), PathChange::kNone);
  }
  EXPECT_EQ(guessing.machine.state(), PathState::kProbing);
}

TEST(PathMachine, PauseDoublesUpToItsLimit) {
  Rig rig = unanswered_rig();
  static_cast<void>(rig.run(60s));
  std::vector<Duration> pauses;  // from a round's last challenge to the next one's first
  for (std::size_t i = 5; i < rig.sent.size(); i += 5) {
    pauses.push_back(rig.sent[i].at - rig.sent[i - 1].at - 500ms);
  }
  ASSERT_GE(pauses.size(), 6U);
  const Duration expected[] = {500ms, 1s, 2s, 4s, 8s, 8s};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(pauses[i], expected[i]) << i;
}

TEST(PathMachine, SilenceOf100MsFallsBack) {
  Rig rig = rig_in_use(1s);
  rig.lost = always;
  const TimePoint cut = rig.now;
  ASSERT_EQ(rig.machine.silence_limit(), 100ms);
  while (rig.machine.in_use()) static_cast<void>(rig.run(1ms));
  // From the first challenge that was lost, which left at most 10 ms after the cut.
  EXPECT_GE(rig.now - cut, 100ms);
  EXPECT_LE(rig.now - cut, 112ms);
  EXPECT_EQ(rig.machine.state(), PathState::kWaiting);
}

TEST(PathMachine, SlowLinksAllowALongerSilence) {
  PathRules slow;
  slow.nominal_period = 100ms;
  Rig by_period(slow);
  EXPECT_EQ(by_period.machine.silence_limit(), 400ms);
  Rig by_rtt;
  by_rtt.rtt = 90ms;
  by_rtt.machine.start(kServer, by_rtt.now);
  EXPECT_EQ(by_rtt.run(5s), Changes{PathChange::kUp});
  EXPECT_EQ(by_rtt.machine.silence_limit(), 270ms);
}

TEST(PathMachine, ReturnsAfterTheBackOff) {
  Rig rig = rig_in_use(1s);
  rig.lost = always;
  EXPECT_EQ(rig.run(300ms), Changes{PathChange::kSilent});
  rig.lost = nullptr;
  const TimePoint healed = rig.now;
  while (!rig.machine.in_use() && rig.now < healed + 5s) static_cast<void>(rig.run(1ms));
  EXPECT_TRUE(rig.machine.in_use());
  EXPECT_LE(rig.now - healed, 600ms);  // back-off 500 ms from the fallback, a round of 70 ms
}

TEST(PathMachine, ProvenPathResetsItsBackOff) {
  const auto pause_after = [](Duration in_use) {
    Rig rig = started();
    rig.lost = [](int number, const DueChallenge&) { return number <= 10; };  // two rounds fail
    while (!rig.machine.in_use()) static_cast<void>(rig.run(1ms));
    static_cast<void>(rig.run(in_use));
    rig.lost = always;
    while (rig.machine.in_use()) static_cast<void>(rig.run(1ms));
    const TimePoint down = rig.now;
    while (rig.machine.state() == PathState::kWaiting) static_cast<void>(rig.run(1ms));
    return rig.now - down;
  };
  EXPECT_NEAR(std::chrono::duration<double>(pause_after(11s)).count(), 0.5, 0.002);
  EXPECT_NEAR(std::chrono::duration<double>(pause_after(1s)).count(), 2.0, 0.002);
}

TEST(PathMachine, FallsBackOn30PercentLoss) {
  for (const double delivered : {0.75, 0.65}) {
    Rig rig = started();
    rig.delivered = delivered;
    const TimePoint begin = rig.now;
    Changes changes;
    while (rig.now < begin + 3s && changes != Changes{PathChange::kLossy}) changes = rig.run(1ms);
    if (delivered > 0.7) {
      EXPECT_TRUE(rig.machine.in_use());
    } else {
      EXPECT_EQ(changes, Changes{PathChange::kLossy});
      EXPECT_GE(rig.now - begin, 1s);
      EXPECT_LE(rig.now - begin, 1300ms);
    }
  }
}

TEST(PathMachine, OwnPauseIsNotSilence) {
  Rig rig = rig_in_use();
  rig.now += 300ms;  // stopped; answers to what was sent before wait in the buffers
  EXPECT_EQ(rig.run(500ms), Changes{});
}

TEST(PathMachine, NewAddressMustAnswerARound) {
  Rig rig = rig_in_use();
  rig.machine.heard(kElsewhere, rig.now);
  EXPECT_EQ(rig.run(70ms), Changes{});
  EXPECT_EQ(rig.machine.address(), kServer);
  EXPECT_TRUE(rig.machine.in_use());
  EXPECT_EQ(rig.run(5ms), Changes{PathChange::kMoved});
  EXPECT_EQ(rig.machine.address(), kElsewhere);
}

TEST(PathMachine, ManyAddressesShareOneRound) {
  Rig rig = rig_in_use();
  rig.lost = [](int, const DueChallenge& challenge) { return !(challenge.to == kServer); };
  const std::size_t before = rig.sent.size();
  for (int ms = 0; ms < 2000; ++ms) {
    rig.machine.heard(address(static_cast<std::uint16_t>(20'000 + ms)), rig.now);
    static_cast<void>(rig.run(1ms));
  }
  std::size_t to_others = 0;
  for (std::size_t i = before; i < rig.sent.size(); ++i) {
    if (!(rig.sent[i].challenge.to == kServer)) ++to_others;
  }
  EXPECT_GT(to_others, 0U);
  EXPECT_LE(to_others, 4U * 5U);
  EXPECT_EQ(rig.machine.address(), kServer);
  EXPECT_TRUE(rig.machine.in_use());
}

TEST(PathMachine, CloseTurnsItOffForGood) {
  Rig rig = rig_in_use();
  EXPECT_EQ(rig.machine.closed(), PathChange::kClosed);
  EXPECT_EQ(rig.machine.closed(), PathChange::kNone);
  rig.sent.clear();
  EXPECT_EQ(rig.run(20s), Changes{});
  EXPECT_TRUE(rig.sent.empty());
}

TEST(PathMachine, IsIdleUntilItsNextStep) {
  Rig rig = started();
  rig.lost = [](int number, const DueChallenge&) { return number % 7 == 0; };
  for (int ms = 0; ms < 20'000; ++ms) {
    const TimePoint named = rig.machine.next_step();
    const std::size_t sent = rig.sent.size();
    const bool answered = !rig.answers.empty() && rig.answers.front().at <= rig.now;
    const Changes changes = rig.run(1ms);
    if (answered || rig.now - 1ms >= named) continue;
    ASSERT_EQ(changes, Changes{}) << ms;
    ASSERT_EQ(rig.sent.size(), sent) << ms;
  }
}

TEST(PathMachine, StatesAndChangesHaveNames) {
  for (int i = 0; i < 4; ++i) EXPECT_STRNE(name(static_cast<PathState>(i)), "UNKNOWN");
  for (int i = 0; i < 7; ++i) EXPECT_STRNE(name(static_cast<PathChange>(i)), "UNKNOWN");
}

}  // namespace
}  // namespace haptic::wire
