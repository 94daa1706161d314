/// The rows of WIRE 6 that no scenario file can say, over real sockets: an attacker on the way,
/// clients that die or pause, watchers, the end of the server under load. Real time, label
/// `network`.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <limits>

#include "haptic/wire/secure_channel.hpp"
#include "tests/relay/daemon.hpp"
#include "tests/relay/matrix_table.hpp"
#include "tests/relay/presser.hpp"
#include "tests/relay/relay.hpp"
#include "tests/relay/run_record.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

RelaySetup between(const Daemon& daemon, const char* scenario = "delay_10ms") {
  RelaySetup setup;
  setup.scenario = read_scenario(std::string(HAPTIC_SOURCE_DIR "/tests/relay/scenarios/") +
                                 scenario + ".textproto");
  setup.tcp_port = daemon.tcp_port();
  setup.udp_port = daemon.udp_port();
  return setup;
}

bool engaged_by_udp(Presser& presser) {
  return within(20s, [&] {
    const auto state = presser.state();
    return state.state == client::State::kEngaged && state.transport == client::Transport::kUdp;
  });
}

/// Ends the daemon and holds the contract against what it recorded.
RunFigures end_and_judge(Daemon& daemon) {
  EXPECT_EQ(daemon.stop(), 0);
  std::string wrong;
  const RunFigures figures = judge(read_record(daemon.record()), Presser::kFreshEnd, wrong);
  EXPECT_EQ(wrong, "");
  return figures;
}

/// An attack during three seconds of pressing is not felt: never stale by more than a hold, on UDP
/// all along.
void siege(const std::string& name,
           const std::function<std::vector<Packet>(const Packet&)>& attacker,
           const std::function<void(Daemon&)>& meanwhile = {}) {
  MatrixRow row("network/" + name, "contract; engaged throughout; stays on UDP; no reply");
  Daemon daemon;
  ASSERT_TRUE(serves(daemon.address()));
  std::atomic<bool> attacking{false};
  std::atomic<std::uint64_t> forged{0};
  {
    RelaySetup setup = between(daemon);
    setup.attacker = [&](const Packet& packet) {
      auto packets = attacker(packet);
      if (!attacking) packets.clear();
      forged += packets.size();
      return packets;
    };
    const Relay relay(setup);
    Presser presser(daemon.behind_relay());
    ASSERT_TRUE(engaged_by_udp(presser));
    attacking = true;
    if (meanwhile) meanwhile(daemon);
    std::this_thread::sleep_for(3s);
    attacking = false;
    EXPECT_FALSE(presser.heard("SAMPLES UDP -> GRPC"));
    EXPECT_TRUE(presser.in_order());
  }
  const RunFigures figures = end_and_judge(daemon);
  EXPECT_EQ(figures.losses, 0);
  row.got(std::to_string(forged) + " forged datagrams");
  row.got(figures.text());
}

TEST(NetworkRow, BitFlips) {
  siege("bit_flips", [random = Random(3)](const Packet& packet) mutable {
    std::vector<Packet> damaged(3, packet);
    for (Packet& copy : damaged) {
      copy[random.next() % copy.size()] ^= static_cast<std::uint8_t>(1U << random.next() % 8);
    }
    return damaged;
  });
}

TEST(NetworkRow, WrongKey) {
  std::unique_ptr<wire::SecureChannel> forger;
  siege("wrong_key", [&](const Packet& packet) {
    const wire::HeaderReading reading = wire::read_header(packet);
    if (!forger) {
      wire::PathKeys guessed = wire::fresh_keys();
      guessed.path_id = reading.header.path_id;
      forger = std::make_unique<wire::SecureChannel>(wire::End::kClient, guessed);
    }
    Packet forged(wire::kLargestDatagram);
    forged.resize(forger->seal(wire::DatagramType::kProxy, Packet(40, 0x11), forged));
    wire::put(reading.header.packet_number + 100, wire::Bytes(forged).subspan(8));
    return std::vector<Packet>{forged};
  });
}

TEST(NetworkRow, ReplayedCapture) {
  std::vector<Packet> capture;
  std::size_t next = 0;
  siege("replayed_capture", [&](const Packet& packet) {
    capture.push_back(packet);
    return std::vector<Packet>{capture[next++ / 2]};  // ever older ones
  });
}

/// A socket of an attacker's own: what it hears back.
class Stranger {
 public:
  Stranger() : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {}
  ~Stranger() { ::close(socket_); }
  Stranger(const Stranger&) = delete;
  Stranger& operator=(const Stranger&) = delete;
  void send(const Packet& packet, std::uint16_t port) const {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    static_cast<void>(::sendto(socket_, packet.data(), packet.size(), 0,
                               reinterpret_cast<const sockaddr*>(&to), sizeof to));
  }
  [[nodiscard]] bool heard_anything() const {
    char byte = 0;
    return ::recv(socket_, &byte, 1, 0) >= 0;
  }

 private:
  int socket_;
};

TEST(NetworkRow, SpoofedSource) {
  const Stranger stranger;
  std::mutex mutex;
  std::vector<Packet> seen;
  siege(
      "spoofed_source",
      [&](const Packet& packet) {
        const std::lock_guard lock(mutex);
        seen.push_back(packet);
        return std::vector<Packet>{};
      },
      [&](Daemon& daemon) {
        const std::lock_guard lock(mutex);
        // Those of the last 10 ms may still be on their way.
        for (std::size_t i = 0; i + 20 < seen.size(); ++i) {
          stranger.send(seen[i], daemon.udp_port());
        }
      });
  EXPECT_GT(seen.size(), 100U);
  EXPECT_FALSE(stranger.heard_anything());
}

TEST(NetworkRow, ACutConnectionIsResumed) {
  MatrixRow row("network/cut_connection",
                "contract; resumed within the lease; force back by itself");
  Daemon daemon;
  ASSERT_TRUE(serves(daemon.address()));
  {
    auto relay = std::make_unique<Relay>(between(daemon, "clean"));
    Presser presser(daemon.behind_relay());
    ASSERT_TRUE(engaged_by_udp(presser));
    relay.reset();  // both carriers
    relay = std::make_unique<Relay>(between(daemon, "clean"));
    EXPECT_TRUE(within(10s, [&] { return presser.heard("LEASE_RESUMED"); }));
    EXPECT_EQ(presser.session().lease_epoch(), 2U);
    EXPECT_TRUE(engaged_by_udp(presser)) << "new keys, and a path of its own";
    EXPECT_TRUE(presser.in_order());
  }
  row.got(end_and_judge(daemon).text());
}
TEST(NetworkRow, ClientKilled) {
  MatrixRow row("network/client_killed", "contract; no force and IDLE in the end");
  Daemon daemon;
  ASSERT_TRUE(serves(daemon.address()));
  {
    const Relay relay(between(daemon));
    Process wall(HAPTIC_BINARY_DIR "/client/haptic-example-virtual-wall",
                 {"--server", daemon.behind_relay(), "--stop", "0.3"});
    client::Connection watching(daemon.address());
    std::atomic<bool> pressed{false};
    const auto watch = watching.watch("finger", 100.0, [&](const client::DeviceState& state) {
      if (state.state == client::State::kEngaged && state.gain == 1.0) pressed = true;
    });
    ASSERT_TRUE(within(20s, [&] { return pressed.load(); }));
    wall.signal(SIGKILL);
    wall.wait();
    std::this_thread::sleep_for(3s);
    EXPECT_EQ(watching.devices().front().state, client::State::kIdle);
  }
  EXPECT_EQ(daemon.stop(), 0);
  const auto run = read_record(daemon.record());
  std::string wrong;
  const RunFigures figures = judge(run, 2.5 / 200.0, wrong);  // the example's rate
  EXPECT_EQ(wrong, "");
  EXPECT_EQ(run.back().tau_a, 0.0);
  row.got(figures.text());
}

TEST(NetworkRow, ClientPausedFor300Ms) {
  MatrixRow row("network/client_paused_300ms", "contract; lost once, and engaged again");
  Daemon daemon;
  ASSERT_TRUE(serves(daemon.address()));
  {
    const Relay relay(between(daemon));
    Presser presser(daemon.behind_relay());
    ASSERT_TRUE(engaged_by_udp(presser));
    presser.publishing = false;
    std::this_thread::sleep_for(300ms);
    presser.publishing = true;
    EXPECT_TRUE(within(5s, [&] { return presser.heard("LOST"); }));
    EXPECT_TRUE(engaged_by_udp(presser));
  }
  const RunFigures figures = end_and_judge(daemon);
  EXPECT_EQ(figures.losses, 1);
  row.got(figures.text());
}

/// A number that no proxy may have: refused and counted, as good as silence, and force comes back
/// by a ramp.
void refuses(const std::string& name, double bad) {
  MatrixRow row("network/" + name, "contract; refused and counted; lost once, and engaged again");
  Daemon daemon;
  ASSERT_TRUE(serves(daemon.address()));
  std::uint64_t refused = 0;
  {
    const Relay relay(between(daemon));
    Presser presser(daemon.behind_relay());
    ASSERT_TRUE(engaged_by_udp(presser));
    presser.instead = &bad;
    EXPECT_TRUE(within(5s, [&] { return presser.heard("LOST"); }));
    presser.instead = nullptr;
    EXPECT_TRUE(engaged_by_udp(presser));
    refused = presser.session().statistics().rejected_invalid;
  }
  const RunFigures figures = end_and_judge(daemon);
  EXPECT_EQ(figures.losses, 1);
  EXPECT_GE(refused, 15U);  // 180 ms at 100 Hz, but for what the way had under way
  row.got(std::to_string(refused) + " refused");
  row.got(figures.text());
}

TEST(NetworkRow, NotANumber) {
  refuses("nan", std::numeric_limits<double>::quiet_NaN());
}

TEST(NetworkRow, HugeValues) {
  refuses("huge_values", 1e300);
}

TEST(NetworkRow, SixteenObserversAt1Khz) {
  MatrixRow row("network/16_observers", "contract; engaged throughout beside 16 watchers");
  Daemon daemon;
  ASSERT_TRUE(serves(daemon.address()));
  std::atomic<std::uint64_t> states{0};
  {
    client::Connection connection(daemon.address());
    std::vector<std::unique_ptr<client::Watch>> watches;
    for (int i = 0; i < 16; ++i) {
      watches.push_back(
          connection.watch("finger", 1000.0, [&](const client::DeviceState&) { ++states; }));
    }
    Presser presser(daemon.address());
    ASSERT_TRUE(within(20s, [&] { return presser.state().state == client::State::kEngaged; }));
    std::this_thread::sleep_for(4s);
  }
  const RunFigures figures = end_and_judge(daemon);
  EXPECT_EQ(figures.losses, 0);
  EXPECT_GT(states, 16'000U);
  row.got(std::to_string(states) + " states to them");
  row.got(figures.text());
}

TEST(NetworkRow, SigtermUnderLoad) {
  MatrixRow row("network/sigterm_under_load", "contract; CLOSING without force; exit 0 within 5 s");
  Daemon daemon;
  ASSERT_TRUE(serves(daemon.address()));
  const Relay relay(between(daemon, "loss_05"));
  Presser presser(daemon.behind_relay());
  ASSERT_TRUE(engaged_by_udp(presser));
  const auto before = std::chrono::steady_clock::now();
  const RunFigures figures = end_and_judge(daemon);
  EXPECT_LT(std::chrono::steady_clock::now() - before, 5s);
  EXPECT_EQ(figures.last_state, "CLOSING");
  EXPECT_EQ(read_record(daemon.record()).back().tau_a, 0.0);
  row.got(figures.text());
}

}  // namespace
}  // namespace haptic::test
