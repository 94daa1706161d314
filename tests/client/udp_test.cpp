/// The UDP path of the client against a scripted server: samples by UDP where the path is good, by
/// the stream where it is not, and never a sample lost to the change.

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <netdb.h>

#include <atomic>
#include <cstring>
#include <set>

#include "tests/client/support/fake_server.hpp"
#include "tests/support/udp_end.hpp"

/// The system's, but that two.example has two addresses, and nobody listens at the first.
// NOLINTNEXTLINE(readability-inconsistent-declaration-parameter-name): netdb.h has reserved ones
extern "C" int getaddrinfo(const char* host, const char* service, const addrinfo* hints,
                           addrinfo** found) {
  static const auto system =
      reinterpret_cast<decltype(&getaddrinfo)>(::dlsym(RTLD_NEXT, "getaddrinfo"));
  if (host == nullptr || std::strcmp(host, "two.example") != 0) {
    return system(host, service, hints, found);
  }
  addrinfo *first = nullptr, *second = nullptr;
  const int failed = system("127.0.0.3", service, hints, &first);
  if (failed != 0) return failed;
  const int failed_too = system("127.0.0.1", service, hints, &second);
  if (failed_too != 0) {
    freeaddrinfo(first);
    return failed_too;
  }
  addrinfo* last = first;
  while (last->ai_next != nullptr) last = last->ai_next;
  last->ai_next = second;
  *found = first;
  return 0;
}

namespace haptic::test {
namespace {

using client::Carriers;
using client::Proxy;
using client::Session;
using client::SessionOptions;
using namespace std::chrono_literals;

v1::UdpPath offer(const wire::PathKeys& keys, std::uint16_t port) {
  const auto text = [](const auto& bytes) { return std::string(bytes.begin(), bytes.end()); };
  v1::UdpPath udp;
  udp.set_port(port);
  udp.set_path_id(keys.path_id);
  udp.set_up_key(text(keys.up.key));
  udp.set_up_salt(text(keys.up.salt));
  udp.set_down_key(text(keys.down.key));
  udp.set_down_salt(text(keys.down.salt));
  return udp;
}

/// A server of both carriers, and a session that was offered UDP.
class ClientUdp : public WithServer {
 protected:
  ClientUdp() { server.offer_udp(offer(keys, udp.port())); }

  [[nodiscard]] bool in_use(const Session& session) {
    return server.until([&] { return session.udp_link() && session.udp_link()->in_use; });
  }
  void send_state(std::uint64_t seq) {
    v1::DeviceState state;
    state.set_seq(seq);
    state.set_state(v1::DEVICE_STATE_NAME_ARMED);
    state.set_transport(v1::TRANSPORT_UDP);
    EXPECT_TRUE(udp.send(state.SerializeAsString()));
  }
  /// Numbers of the samples that came, by either carrier.
  [[nodiscard]] std::set<std::uint64_t> numbers() {
    std::set<std::uint64_t> numbers;
    for (const v1::ProxySample& sample : server.heard().samples) numbers.insert(sample.seq());
    for (const std::string& message : udp.messages()) {
      v1::ProxySample sample;
      EXPECT_TRUE(sample.ParseFromString(message));
      numbers.insert(sample.seq());
    }
    return numbers;
  }

  wire::PathKeys keys = wire::fresh_keys();
  UdpEnd udp{wire::End::kServer, keys};
};

TEST_F(ClientUdp, IsTakenOncePathIsGood) {
  udp.cut = true;
  const auto session = open();
  EXPECT_TRUE(server.heard().openings.front().udp_wanted());
  session->publish(Proxy::held({0.01}));
  ASSERT_TRUE(streamed(1));  // by the stream so far
  udp.cut = false;
  ASSERT_TRUE(in_use(*session));
  session->publish(Proxy::held({0.02}));
  ASSERT_TRUE(server.until([&] { return udp.messages().size() == 1; }));
  v1::ProxySample sample;
  ASSERT_TRUE(sample.ParseFromString(udp.messages().front()));
  EXPECT_EQ(sample.seq(), 2U);
  EXPECT_EQ(sample.position(0), 0.02);
  EXPECT_EQ(server.heard().samples.size(), 1U);
  EXPECT_EQ(session->statistics().sent, 2U);
}

TEST_F(ClientUdp, OldStatesReachNoCallback) {
  std::atomic<std::uint64_t> newest{0};
  std::atomic<bool> fell{false};
  SessionOptions options;
  options.on_state = [&](const client::DeviceState& state) {
    fell = fell || state.seq <= newest;
    newest = state.seq;
  };
  const auto session = open(options);
  ASSERT_TRUE(in_use(*session));
  ASSERT_TRUE(server.until([&] { return udp.in_use(); }));
  send_state(5);
  ASSERT_TRUE(server.until([&] { return newest == 5; }));
  EXPECT_EQ(session->state().carrier, client::Carrier::kUdp);
  server.send_state(4);  // was slower, on the stream
  server.send_state(6);
  ASSERT_TRUE(server.until([&] { return newest == 6; }));
  send_state(5);
  send_state(7);
  ASSERT_TRUE(server.until([&] { return newest == 7; }));
  EXPECT_FALSE(fell);
}

TEST_F(ClientUdp, SilentPathSendsTheNewestAgain) {
  const auto session = open();
  ASSERT_TRUE(in_use(*session));
  udp.cut = true;
  session->publish(Proxy::held({0.03}));  // into the void, and nothing follows it
  ASSERT_TRUE(server.until([&] { return !server.heard().samples.empty(); }));
  EXPECT_EQ(server.heard().samples.front().seq(), 1U);
  EXPECT_EQ(server.heard().samples.front().position(0), 0.03);
  ASSERT_TRUE(server.until([&] { return !session->udp_link()->in_use; }));
  session->publish(Proxy::held({0.04}));
  ASSERT_TRUE(streamed(2));  // the first came once
  udp.cut = false;
  ASSERT_TRUE(in_use(*session));  // and back by itself
  session->publish(Proxy::held({0.05}));
  ASSERT_TRUE(server.until([&] { return numbers().count(3) == 1; }));
  EXPECT_EQ(server.heard().samples.size(), 2U);
}

TEST_F(ClientUdp, RepeatsNothingWithoutASample) {
  const auto session = open();
  ASSERT_TRUE(in_use(*session));
  udp.cut = true;  // doubt first, silence then
  ASSERT_TRUE(server.until([&] { return !session->udp_link()->in_use; }));
  EXPECT_FALSE(server.until([&] { return !server.heard().samples.empty(); }, 50ms));
}

TEST_F(ClientUdp, PinnedToStreamItAsksNot) {
  SessionOptions options{.carriers = Carriers::kGrpcOnly};
  const auto session = open(options);
  EXPECT_FALSE(server.heard().openings.front().udp_wanted());
  session->publish(Proxy::held({0.01}));
  ASSERT_TRUE(streamed(1));
  EXPECT_FALSE(session->udp_link());
  EXPECT_FALSE(server.until([&] { return udp.arrivals() > 0; }, 50ms));  // although it is offered
}

TEST_F(ClientUdp, NewKeysAreTakenWithoutGap) {
  const auto session = open();
  ASSERT_TRUE(in_use(*session));
  const wire::PathKeys next = wire::fresh_keys();
  udp.rekey(next);
  v1::SessionResponse message;
  *message.mutable_udp() = offer(next, udp.port());
  server.send(message);
  for (int i = 0; i < 100; ++i) {
    session->publish(Proxy::held({0.01}));
    std::this_thread::sleep_for(2ms);
  }
  ASSERT_TRUE(server.until([&] { return numbers().size() == 100; }));
  EXPECT_TRUE(session->udp_link()->in_use);
  // A machine that pauses sends some by the stream too, none by the stream alone.
  EXPECT_TRUE(server.until([&] { return udp.messages().size() == 100; }));
}

TEST_F(ClientUdp, EndOfTheStreamEndsIt) {
  const auto session = open();
  ASSERT_TRUE(in_use(*session));
  server.end_session(grpc::Status(grpc::StatusCode::UNAVAILABLE, "closing"));
  ASSERT_TRUE(server.until([&] { return !session->udp_link(); }));
  session->publish(Proxy::held({0.01}));
  EXPECT_TRUE(udp.messages().empty());
}

TEST_F(ClientUdp, TheNextAddressIsTriedToo) {
  v1::UdpPath two = offer(keys, udp.port());
  two.set_host("two.example");
  server.offer_udp(two);
  const auto session = open();
  ASSERT_TRUE(in_use(*session));
  session->publish(Proxy::held({0.01}));
  ASSERT_TRUE(server.until([&] { return udp.messages().size() == 1; }));
  EXPECT_TRUE(server.heard().samples.empty());
}

using ClientWithoutUdp = WithServer;

TEST_F(ClientWithoutUdp, AUdpOnlySessionIsRefused) {
  SessionOptions options{.carriers = Carriers::kUdpOnly};
  const auto error = error_of([&] { return open(options); });
  EXPECT_NE(std::string(error.what()).find("no UDP path"), std::string::npos);
}

}  // namespace
}  // namespace haptic::test
