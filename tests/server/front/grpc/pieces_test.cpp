// The parts of the service that need no socket.
#include <gtest/gtest.h>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/model/hand_exoskeleton.hpp"
#include "haptic/v1/haptic_service.pb.h"
#include "haptic/wire/datagram.hpp"
#include "server/front/grpc/reply.hpp"
#include "server/front/net/protection.hpp"
#include "server/front/service/broadcaster.hpp"
#include "server/front/service/state_frame.hpp"
#include "server/front/session/messages.hpp"
#include "server/front/session/pace.hpp"
#include "server/front/session/refusals.hpp"
#include "server/front/session/sample_ledger.hpp"
#include "server/owner/link/listeners.hpp"
#include "server/owner/state/state_message.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::server {
namespace {

using namespace std::chrono_literals;

int sent_of(Pace& pace, int ticks, int step = 1) {
  int sent = 0;
  for (int tick = 0; tick < ticks; tick += step) {
    if (!pace.due(static_cast<std::uint64_t>(tick))) continue;
    pace.sent(static_cast<std::uint64_t>(tick));
    ++sent;
  }
  return sent;
}

TEST(Pace, KeepsRatesThatDoNotDivide) {
  Pace thirty(1000.0, 30.0);
  EXPECT_EQ(sent_of(thirty, 10000), 300);
  EXPECT_EQ(thirty.conflated(), 0U);
  Pace seven_hundred(1000.0, 700.0);
  EXPECT_NEAR(sent_of(seven_hundred, 10000), 7000, 1);
}

TEST(Pace, CountsWhatWasDueUnsent) {
  Pace pace(1000.0, 0.0);
  EXPECT_EQ(sent_of(pace, 100, 4), 25);  // busy three ticks of four
  EXPECT_EQ(pace.conflated(), 24U * 3U);
}

TEST(SampleLedger, ReportsSamplesAndRejectionsInTime) {
  const core::TimePoint t0{1h};
  SampleLedger ledger;
  ledger.look(t0);
  EXPECT_FALSE(ledger.due());
  ledger.book(1, {});
  ledger.look(t0);
  ASSERT_TRUE(ledger.due());
  EXPECT_EQ(ledger.tell().accepted(), 1U);
  ledger.book(2, {});
  ledger.look(t0 + 49ms);
  EXPECT_FALSE(ledger.due());
  ledger.book(3, {IngressVerdict::kNotFinite, "position[0] = nan"});
  ledger.look(t0 + 49ms);
  ASSERT_TRUE(ledger.due());
  const v1::SampleAck ack = ledger.tell();
  EXPECT_EQ(ack.accepted(), 2U);
  EXPECT_EQ(ack.rejected_invalid(), 1U);
  EXPECT_EQ(ack.newest_seq(), 2U);
  EXPECT_EQ(ack.last_rejection(), "position[0] = nan");
  ledger.look(t0 + 10s);
  EXPECT_FALSE(ledger.due());  // nothing new to tell
}

TEST(WatchBudget, GivesItsRateAndKeepsLittle) {
  WatchBudget budget(1000.0);
  core::TimePoint now{1h};
  int given = 0;
  for (int i = 0; i < 1000; ++i) {
    budget.refill(now += 1ms);
    while (budget.left()) {
      budget.take();
      ++given;
    }
  }
  EXPECT_NEAR(given, 1000, 5);
  budget.refill(now += 10s);
  int burst = 0;
  for (; budget.left(); ++burst) budget.take();
  EXPECT_LE(burst, 4);
}

TEST(StateFrame, PassesTheStatesBytesOn) {
  v1::WatchResponse expected;
  expected.mutable_state()->set_seq(77);
  expected.mutable_state()->add_tau_a(-1.5);
  expected.set_conflated(123456);
  SerialisedState state;
  state.size = static_cast<std::uint32_t>(expected.state().ByteSizeLong());
  ASSERT_TRUE(expected.state().SerializeToArray(state.bytes.data(), SerialisedState::kMost));
  StateFrame frame(state);
  grpc::Slice slice;
  ASSERT_TRUE(to_buffer(frame.for_watch(123456)).DumpToSingleSlice(&slice).ok());
  v1::WatchResponse parsed;
  ASSERT_TRUE(parsed.ParseFromArray(slice.begin(), static_cast<int>(slice.size())));
  EXPECT_EQ(parsed.SerializeAsString(), expected.SerializeAsString());
  ASSERT_TRUE(to_buffer(frame.for_session()).DumpToSingleSlice(&slice).ok());
  v1::SessionResponse session;
  ASSERT_TRUE(session.ParseFromArray(slice.begin(), static_cast<int>(slice.size())));
  EXPECT_EQ(session.state().SerializeAsString(), expected.state().SerializeAsString());
  const auto datagram = frame.for_datagram();
  EXPECT_EQ(std::string(datagram.begin(), datagram.end()), expected.state().SerializeAsString());
}

TEST(LargestState, HandsFitADatagram) {
  core::PipelineConfig config{
      .kinematics = core::make_hand_exoskeleton(
          {{"thumb", {}}, {"index", {}}, {"middle", {}}, {"ring", {}}, {"little", {}}})};
  EXPECT_LE(largest_state(config), wire::kLargestPayload);
  core::TrackedHandParameters hand;
  for (const char* name : {"index", "middle", "ring", "little"}) {
    hand.fingers.push_back({{name, {}}, {}});
    for (const auto phalanx : {core::Phalanx::kProximal, core::Phalanx::kMiddle}) {
      hand.outputs.push_back({name + std::to_string(hand.outputs.size()),
                              name,
                              phalanx,
                              core::OutputKind::kPoint,
                              {{0.03, 0.0, 0.0}, {}}});
    }
  }
  config.kinematics = core::make_tracked_hand(hand);
  EXPECT_LE(largest_state(config), wire::kLargestPayload);
}

TEST(Messages, ASampleKeepsTheWiresCounts) {
  v1::ProxySample sample;
  sample.set_mode(v1::PROXY_MODE_PLANES);
  for (int i = 0; i < 8; ++i) {
    v1::Plane& plane = *sample.add_planes();
    plane.add_normal(i + 1.0);
    plane.set_offset(0.5 * i);
  }
  ProxySample taken;
  from_proto(sample, taken);
  EXPECT_EQ(taken.mode, core::ProxyMode::kPlanes);
  EXPECT_EQ(taken.plane_count, 8U) << "as on the wire; the ingress refuses it";
  EXPECT_EQ(taken.planes[5].normal.value[0], 6.0);
  EXPECT_EQ(taken.planes[5].normal.count, 1U);
  EXPECT_EQ(taken.planes[5].offset, 2.5);
}

TEST(Messages, ContactLiesBehindItsNormal) {
  v1::ProxySample sample;
  sample.set_device_seq_used(41);
  v1::Plane& plane = *sample.add_planes();
  plane.add_normal(1.0);
  plane.add_normal(2.0);
  plane.set_compliance(3.0);
  plane.set_velocity(4.0);
  plane.set_first_coordinate(1);
  plane.set_id(5);
  plane.set_mass(7.0);
  plane.set_damping(8.0);
  plane.set_ground_stiffness(9.0);
  plane.set_load(10.0);
  plane.add_curvature(6.0);
  plane.set_uncertainty(0.0);
  plane.set_object(11);
  plane.add_object_direction(-1.0);
  v1::Plane& long_one = *sample.add_planes();
  for (int i = 0; i < 100; ++i) long_one.add_normal(1.0);
  for (int i = 0; i < 100; ++i) long_one.add_curvature(1.0);
  for (int i = 0; i < 100; ++i) long_one.add_object_direction(1.0);
  ProxySample taken;
  from_proto(sample, taken);
  EXPECT_EQ(taken.tick_used, 41u);
  const PlaneSample& first = taken.planes[0];
  EXPECT_EQ(first.normal.count, 2u);
  EXPECT_EQ(first.compliance, 3.0);
  EXPECT_EQ(first.velocity, 4.0);
  EXPECT_EQ(first.first_coordinate, 1u);
  EXPECT_EQ(first.id, 5u);
  EXPECT_EQ(first.mass, 7.0);
  EXPECT_EQ(first.damping, 8.0);
  EXPECT_EQ(first.ground_stiffness, 9.0);
  EXPECT_EQ(first.load, 10.0);
  EXPECT_EQ(first.object, 11u);
  EXPECT_EQ(first.object_direction.count, 1u);
  EXPECT_EQ(first.object_direction.value[0], -1.0);
  EXPECT_EQ(taken.planes[1].object_direction.count, 100u) << "the ingress refuses it";
  EXPECT_EQ(first.curvature_count, 1u);
  EXPECT_EQ(first.normal.value[2], 6.0);
  EXPECT_EQ(first.tells_uncertainty, 1u) << "0 is exact, not absent";
  EXPECT_EQ(taken.planes[1].tells_uncertainty, 0u);
  EXPECT_EQ(taken.planes[1].curvature_count, 100u) << "as on the wire; the ingress refuses it";
}

TEST(Text, ClientCannotSteerATerminal) {
  EXPECT_EQ(sanitised("a\x1b[2J\nb\x7f", 64), "a?[2J?b?");
  EXPECT_EQ(sanitised("Gr\xc3\xbc\xc3\x9f", 64), "Gr\xc3\xbc\xc3\x9f");
  EXPECT_EQ(sanitised("ab\xc3\xbc", 3), "ab");  // never half a character
  EXPECT_EQ(sanitised("a\u009bb\u202ec\u2069d\u200fe\u061cf", 64), "a?b?c?d?e?f");
  EXPECT_EQ(sanitised("\u00a0\u2010\u2026\u206a", 64), "\u00a0\u2010\u2026\u206a");
}

std::string refusal_of(const std::string& address) {
  return test::message_of<core::TransportError>([&] { return check_listen_address(address); });
}

TEST(ListenAddress, OtherHostsNeedTlsOrFlag) {
  for (const char* address : {"127.0.0.1:29470", "127.8.9.1:0", "localhost:1", "[::1]:29470"}) {
    EXPECT_EQ(check_listen_address(address), Protection::kThisHost) << address;
    EXPECT_EQ(check_listen_address(address, Protection::kInsecureLab), Protection::kThisHost);
    EXPECT_EQ(check_listen_address(address, Protection::kMutualTls), Protection::kMutualTls);
  }
  for (const char* address : {"0.0.0.0:29470", "[::]:29470", "192.168.1.7:29470", "robot:1",
                              "127.evil.example:1", "127.0.0.1.evil.example:1"}) {
    for (const Protection best :
         {Protection::kTls, Protection::kMutualTls, Protection::kInsecureLab}) {
      EXPECT_EQ(check_listen_address(address, best), best);
    }
    for (const char* part : {address, "server.tls", "--insecure-lab"}) {
      EXPECT_NE(refusal_of(address).find(part), std::string::npos) << address;
    }
  }
  EXPECT_EQ(check_listen_address("unix:/nowhere/s", Protection::kTls), Protection::kThisHost);
}

TEST(ListenAddress, ReportsTheMissingProtection) {
  using server::Protection;
  EXPECT_EQ(server::weakness("robot:1", Protection::kMutualTls), "");
  for (const Protection weak :
       {Protection::kThisHost, Protection::kTls, Protection::kInsecureLab}) {
    EXPECT_NE(server::weakness("robot:1", weak).find("robot:1"), std::string::npos);
  }
  EXPECT_NE(server::weakness("robot:1", Protection::kInsecureLab).find("--insecure-lab"),
            std::string::npos);
  // Without a certificate nobody is an operator (TlsTest).
  const std::string no_certificates = server::weakness("robot:1", Protection::kTls);
  EXPECT_NE(no_certificates.find("PRIORITY_PRIMARY at most"), std::string::npos);
  EXPECT_EQ(no_certificates.find("OPERATOR"), std::string::npos);
}

TEST(ListenAddress, OtherFilesAreRefused) {
  EXPECT_NE(refusal_of("unix:/etc").find("no socket"), std::string::npos);
}

}  // namespace
}  // namespace haptic::server
