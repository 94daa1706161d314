/// The UDP path of the server over real sockets, against a client on wire::PathEnd alone.

#include <gtest/gtest.h>

#include <set>

#include "haptic/core/error.hpp"
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

TEST(UdpService, RefusesAnAddressBeyondThisHost) {
  EXPECT_THROW(LiveServer({.listen = {"127.0.0.1:0"}, .udp_listen = "0.0.0.0:0"}),
               core::TransportError);
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

TEST(UdpService, ForceFromSamplesByUdp) {
  LiveServer server(with_udp());
  UdpSession alice(server);
  std::uint64_t seq = 0;
  ASSERT_TRUE(eventually([&] {
    EXPECT_TRUE(alice.udp->send(proxy_sample(++seq, 0.01, v1::PROXY_MODE_FREE)));
    std::this_thread::sleep_for(9ms);
    if (alice.newest_state().state() == v1::DEVICE_STATE_NAME_ARMED) {
      static_cast<void>(alice.session.engage());
    }
    return alice.newest_state().state() == v1::DEVICE_STATE_NAME_ENGAGED;
  }));
  ASSERT_TRUE(eventually([&] {
    alice.udp->send(proxy_sample(++seq, 0.01));
    std::this_thread::sleep_for(5ms);
    return std::abs(alice.newest_state().tau_a(0) - 1.0) < 1e-9;  // 0.01 m at 100 N/m
  }));
  EXPECT_EQ(alice.newest_state().transport(), v1::TRANSPORT_UDP);
  EXPECT_TRUE(eventually([&] { return alice.heard_reason("SAMPLES GRPC -> UDP"); }));
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
  const auto begin = std::chrono::steady_clock::now();
  for (std::uint64_t seq = 1; seq <= 120; ++seq) {  // the last one by UDP
    if (seq % 2 == 1) {
      ASSERT_TRUE(alice.session.publish({0.001, 0.0}, seq));
    } else {
      ASSERT_TRUE(alice.udp->send(proxy_sample(seq, 0.001)));
    }
    ASSERT_TRUE(eventually([&] { return alice.newest_state().proxy_seq_used() == seq; }));
    std::this_thread::sleep_for(5ms);
  }
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  // The end of it is told once there is leave, by the next sample that came the same way.
  ASSERT_TRUE(eventually([&, seq = std::uint64_t{120}]() mutable {
    alice.udp->send(proxy_sample(++seq, 0.001));
    std::this_thread::sleep_for(10ms);
    std::string last;
    for (const v1::Event& event : alice.session.events()) {
      if (event.reason().rfind("SAMPLES", 0) == 0) last = event.reason();
    }
    return last == "SAMPLES GRPC -> UDP";
  }));
  const auto events = alice.session.events();
  const auto told = std::count_if(events.begin(), events.end(), [](const v1::Event& event) {
    return event.reason().rfind("SAMPLES", 0) == 0;
  });
  EXPECT_GE(told, 4);
  EXPECT_LE(static_cast<double>(told), 4.0 * (seconds + 3.0));
  EXPECT_LT(told, 60);  // of 119 changes
}

TEST(UdpService, CarrierChangeDoesNotMoveForce) {
  LiveServer server(with_udp());
  UdpSession alice(server);
  TestSession watcher(server.channel(), v1::ROLE_OBSERVER, "watcher");
  alice.session.stream(0.01);
  ASSERT_TRUE(eventually([&] {
    if (watcher.state().state() == v1::DEVICE_STATE_NAME_ARMED) {
      static_cast<void>(alice.session.engage());
    }
    return watcher.state().gain() == 1.0;
  }));
  alice.session.stop_streaming();
  std::uint64_t seq = alice.session.seq;
  std::set<double> forces;
  std::set<int> carriers;
  for (int i = 0; i < 60; ++i) {  // ten samples by each carrier, in turns, at the nominal 100 Hz
    ++seq;
    if (i / 10 % 2 == 0) {
      ASSERT_TRUE(alice.udp->send(proxy_sample(seq, 0.01)));
    } else {
      ASSERT_TRUE(alice.session.publish({0.01, 0.0}, seq));
    }
    std::this_thread::sleep_for(10ms);
    forces.insert(watcher.state().tau_elastic(0));
    carriers.insert(watcher.state().transport());
  }
  EXPECT_EQ(forces.size(), 1U);  // to the last bit
  EXPECT_EQ(carriers.size(), 2U);
}

TEST(UdpService, ReplayAndJunkGetNoAnswer) {
  LiveServer server(with_udp());
  UdpSession alice(server);
  UdpEnd attacker(wire::End::kServer, wire::fresh_keys());
  std::vector<std::uint8_t> caught = alice.udp->seal(proxy_sample(1, 0.005));
  ASSERT_FALSE(caught.empty());
  alice.udp->send_raw(caught, server.udp_port());
  ASSERT_TRUE(eventually([&] { return alice.session.ack().accepted() == 1; }));
  for (int i = 0; i < 200; ++i) attacker.send_raw(caught, server.udp_port());
  for (std::size_t size = 0; size < 1400; size += 7) {
    attacker.send_raw(std::vector<std::uint8_t>(size, 0x55), server.udp_port());
  }
  caught.back() ^= 1U;
  caught[15] = 0xF0;  // a number of its own
  for (int i = 0; i < 200; ++i) attacker.send_raw(caught, server.udp_port());
  // Behind all of it in the same socket:
  ASSERT_TRUE(alice.udp->send(proxy_sample(2, 0.006)));
  ASSERT_TRUE(eventually([&] { return alice.session.ack().accepted() == 2; }));
  EXPECT_EQ(attacker.arrivals(), 0U);
  EXPECT_EQ(alice.session.ack().rejected_old(), 0U);
  EXPECT_TRUE(alice.udp->in_use());
}

TEST(UdpService, SilentPathReturnsStatesToStream) {
  LiveServer server(with_udp());
  UdpSession alice(server, v1::ROLE_OBSERVER);
  alice.udp->cut = true;
  ASSERT_TRUE(eventually([&] { return alice.heard_reason("STATES UDP -> GRPC"); }));
  const std::size_t before = alice.session.sequence().size();
  ASSERT_TRUE(eventually([&] { return alice.session.sequence().size() > before + 50; }));
  alice.udp->cut = false;
  const std::size_t by_udp = alice.udp->messages().size();
  ASSERT_TRUE(eventually([&] { return alice.udp->messages().size() > by_udp + 50; }));
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
  const auto knock = [&](const UdpSocket& socket) {
    TestEnd late(wire::End::kClient, keys);
    socket.send(late.seal(wire::DatagramType::kPathChallenge, std::string(40, 't')),
                server.udp_port());
  };
  // The path goes with the session, at the latest when gRPC has let go of the stream.
  const UdpSocket first, second;
  ASSERT_TRUE(eventually([&] {
    knock(first);
    return dropped("UNKNOWN_PATH") > 0;
  }));
  for (int i = 0; i < 20; ++i) knock(second);
  second.send(ByteVector(40), server.udp_port());  // the last in the server's socket
  ASSERT_TRUE(eventually([&] { return dropped("MAGIC") == 1; }));
  EXPECT_GT(dropped("UNKNOWN_PATH"), 20U);
  ByteVector answer(2048);
  EXPECT_FALSE(second.receive(answer));
}

}  // namespace
}  // namespace haptic::test
