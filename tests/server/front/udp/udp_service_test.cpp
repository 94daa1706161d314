/// The UDP path of the server over real sockets, against a client on wire::PathEnd alone.

#include <gtest/gtest.h>

#include "tests/proto/wire/channel_pair.hpp"
#include "tests/server/support/test_client.hpp"
#include "tests/support/udp_end.hpp"

namespace haptic::test {
namespace {

server::ServerScene with_udp() {
  return {.listen = {"127.0.0.1:0"}, .udp_listen = "127.0.0.1:0"};
}

v1::SessionRequest wanting_udp(v1::Role role, const std::string& name) {
  v1::SessionRequest message = open_message(role, name);
  message.mutable_open()->set_udp_wanted(true);
  return message;
}

wire::PathKeys keys_of(const v1::UdpPath& udp) {
  wire::PathKeys keys{.path_id = udp.path_id()};
  std::copy_n(udp.up_key().begin(), 16, keys.up.key.begin());
  std::copy_n(udp.up_salt().begin(), 4, keys.up.salt.begin());
  std::copy_n(udp.down_key().begin(), 16, keys.down.key.begin());
  std::copy_n(udp.down_salt().begin(), 4, keys.down.salt.begin());
  return keys;
}

std::string proxy_sample(std::uint64_t seq, double a, v1::ProxyMode mode = v1::PROXY_MODE_HELD) {
  v1::ProxySample message;
  message.set_seq(seq);
  message.set_mode(mode);
  message.add_position(a);
  message.add_position(0.0);
  return message.SerializeAsString();
}

/// A session whose client has both carriers in its hands, and gets its states by UDP.
struct UdpSession {
  explicit UdpSession(LiveServer& server, v1::Role role = v1::ROLE_CONTROLLER)
      : session(server.channel(), wanting_udp(role, "alice")) {
    EXPECT_TRUE(session.opened().has_udp());
    udp = std::make_unique<UdpEnd>(wire::End::kClient, keys_of(session.opened().udp()),
                                   static_cast<std::uint16_t>(session.opened().udp().port()));
    EXPECT_TRUE(eventually([&] { return udp->in_use() && heard_reason("STATES GRPC -> UDP"); }));
  }
  [[nodiscard]] bool heard_reason(const std::string& reason) {
    for (const v1::Event& event : session.events()) {
      if (event.kind() == v1::Event::KIND_TRANSPORT && event.reason() == reason) return true;
    }
    return false;
  }
  [[nodiscard]] v1::DeviceState newest_state() const {
    v1::DeviceState state;
    const auto messages = udp->messages();
    EXPECT_TRUE(messages.empty() || state.ParseFromString(messages.back()));
    return state;
  }

  OpenSession session;
  std::unique_ptr<UdpEnd> udp;
};

TEST(UdpService, IsOfferedOnlyIfWanted) {
  LiveServer server(with_udp());
  OpenSession without(server.channel(), v1::ROLE_OBSERVER, "bob");
  EXPECT_FALSE(without.opened().has_udp());
  OpenSession with(server.channel(), wanting_udp(v1::ROLE_OBSERVER, "alice"));
  EXPECT_EQ(with.opened().udp().port(), server.udp_port());
  EXPECT_NE(with.opened().udp().path_id(), 0U);
  EXPECT_NE(with.opened().udp().up_key(), with.opened().udp().down_key());
  EXPECT_EQ(with.opened().transport(), v1::TRANSPORT_GRPC);
}

TEST(UdpService, AServerWithoutItSaysWhy) {
  LiveServer server;
  OpenSession session(server.channel(), wanting_udp(v1::ROLE_CONTROLLER, "alice"));
  EXPECT_FALSE(session.opened().has_udp());
  EXPECT_NE(session.opened().udp_refused().find("udp_listen"), std::string::npos);
}

TEST(UdpService, StatesComeByOneCarrier) {
  LiveServer server(with_udp());
  UdpSession alice(server, v1::ROLE_OBSERVER);
  ASSERT_TRUE(eventually([&] { return alice.udp->messages().size() > 50; }));
  const std::size_t by_stream = alice.session.sequence().size();
  const std::size_t by_udp = alice.udp->messages().size();
  ASSERT_TRUE(eventually([&] { return alice.udp->messages().size() > by_udp + 50; }));
  EXPECT_LE(alice.session.sequence().size(), by_stream + 2);
  std::uint64_t last = 0;
  for (const std::string& message : alice.udp->messages()) {
    v1::DeviceState state;
    ASSERT_TRUE(state.ParseFromString(message));
    EXPECT_GT(state.seq(), last);
    last = state.seq();
  }
}

TEST(UdpService, BothCarriersShareOneSequence) {
  LiveServer server(with_udp());
  UdpSession alice(server);
  const auto used = [&](std::uint64_t seq) {
    return eventually([&] { return alice.newest_state().proxy_seq_used() == seq; });
  };
  ASSERT_TRUE(alice.session.publish({0.001, 0.0}, 10));
  ASSERT_TRUE(used(10));
  EXPECT_EQ(alice.newest_state().transport(), v1::TRANSPORT_GRPC);
  ASSERT_TRUE(alice.udp->send(proxy_sample(11, 0.002)));
  ASSERT_TRUE(used(11));
  EXPECT_EQ(alice.newest_state().transport(), v1::TRANSPORT_UDP);
  ASSERT_TRUE(alice.session.publish({0.003, 0.0}, 11));
  ASSERT_TRUE(eventually([&] { return alice.session.ack().rejected_old() == 1; }));
  ASSERT_TRUE(alice.session.publish({0.003, 0.0}, 12));
  ASSERT_TRUE(used(12));
  EXPECT_EQ(alice.newest_state().transport(), v1::TRANSPORT_GRPC);
  EXPECT_TRUE(eventually([&] { return alice.heard_reason("SAMPLES UDP -> GRPC"); }));
}

TEST(UdpService, CarrierChangesAreReportedSparingly) {
  LiveServer server(with_udp());
  UdpSession alice(server);
  const auto told = [&] {
    std::vector<std::string> reasons;
    for (const v1::Event& event : alice.session.events()) {
      if (event.reason().rfind("SAMPLES", 0) == 0) reasons.push_back(event.reason());
    }
    return reasons;
  };
  const auto begin = std::chrono::steady_clock::now();
  const auto by = [&](bool udp, std::uint64_t seq) {
    ASSERT_TRUE(udp ? alice.udp->send(proxy_sample(seq, 0.001))
                    : alice.session.publish({0.001, 0.0}, seq));
    ASSERT_TRUE(eventually([&] { return alice.newest_state().proxy_seq_used() == seq; }));
    std::this_thread::sleep_for(5ms);
  };
  std::uint64_t seq = 0;
  while (seq < 120) {
    ++seq;
    by(seq % 2 == 0, seq);
  }
  const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
  // The end of it is told once there is leave, by the next sample that came the same way.
  ASSERT_TRUE(eventually([&] {
    by(true, ++seq);
    const auto reasons = told();
    return !reasons.empty() && reasons.back() == "SAMPLES GRPC -> UDP";
  }));
  EXPECT_GE(told().size(), 4U);
  EXPECT_LE(static_cast<double>(told().size()), 4.0 * (time.count() + 3.0));
  EXPECT_LT(told().size(), 60U);  // of 119 changes
}

TEST(UdpService, AnEndedSessionsPathIsUnknown) {
  LiveServer server(with_udp());
  const auto dropped = [&](const std::string& reason) {
    for (const auto& [name, count] : server.rpc.dropped_datagrams()) {
      if (name == reason) return count;
    }
    return std::uint64_t{0};
  };
  wire::PathKeys keys;
  {
    UdpSession alice(server, v1::ROLE_OBSERVER);  // whose path is in use: the server answers it
    keys = keys_of(alice.session.opened().udp());
    EXPECT_EQ(dropped("UNKNOWN_PATH"), 0U);
  }
  // The path goes with the session, at the latest when gRPC has let go of the stream.
  const UdpSocket late;
  TestEnd end(wire::End::kClient, keys);
  EXPECT_TRUE(eventually([&] {
    late.send(end.seal(wire::DatagramType::kPathChallenge, std::string(40, 't')),
              server.udp_port());
    return dropped("UNKNOWN_PATH") > 0;
  }));
}

}  // namespace
}  // namespace haptic::test
