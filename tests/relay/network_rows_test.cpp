/// The rows of tests/relay/README.md#rows that no scenario file can say, over real sockets: an
/// attacker on the way, clients that die or pause, watchers, the end of the server under load. Real
/// time, label `network`; a run that the host disturbed is done again, so all that a run knows is
/// made in it.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <limits>

#include "haptic/wire/secure_channel.hpp"
#include "tests/relay/network_row.hpp"
#include "tests/relay/relay.hpp"

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

/// The outcome is a finding of the run where it is not so.
bool engages_by_udp(RowRun& run, Presser& presser) {
  const bool engaged = within(20s, [&] {
    const auto state = presser.state();
    return state.state == client::Lifecycle::kEngaged && state.carrier == client::Carrier::kUdp;
  });
  return run.expect(engaged, "engaged over UDP within 20 s");
}

/// Datagrams that the server dropped so far, up to the tag's check: of open sessions and of none.
std::uint64_t rejected_datagrams(client::Connection& server) {
  std::uint64_t sum = 0;
  const auto add = [&sum](const std::vector<client::Rejected>& rejected) {
    for (const client::Rejected& each : rejected) {
      for (auto why = wire::Rejection::kLength; why <= wire::Rejection::kTag;
           why = static_cast<wire::Rejection>(static_cast<int>(why) + 1)) {
        if (each.reason == wire::name(why)) sum += each.count;
      }
    }
  };
  const client::LinkReport links = server.links();
  add(links.unassigned);
  for (const client::SessionLink& session : links.sessions) {
    for (const client::LinkCarrier& link : session.carriers) {
      if (link.carrier == client::Carrier::kUdp) add(link.up.rejected);
    }
  }
  return sum;
}

/// That there was an attack, and that the server's counters show it; `before`: theirs without it.
void expect_rejected(RowRun& run, client::Connection& server, std::uint64_t before,
                     std::uint64_t forged) {
  run.expect(forged > 100U, "more than 100 forged datagrams");
  // But for what the last 100 ms may still have under way.
  const double least = 0.9 * static_cast<double>(forged) - 20.0;
  std::uint64_t rejected = 0;
  const bool shown = within(2s, [&] {
    const std::uint64_t now = rejected_datagrams(server);
    rejected = now - std::min(now, before);
    return static_cast<double>(rejected) >= least;
  });
  run.expect(shown, "nine of ten forged datagrams rejected, by the server's counters");
  run.got(std::to_string(forged) + " forged datagrams, " + std::to_string(rejected) + " rejected");
}

/// After LOST was heard: the state in which force was on may still be the newest here.
bool engages_again_by_udp(RowRun& run, Presser& presser) {
  const bool off = within(5s, [&] { return presser.state().state != client::Lifecycle::kEngaged; });
  return run.expect(off, "no longer engaged within 5 s") && engages_by_udp(run, presser);
}

struct Attack {
  std::function<std::vector<Packet>(const Packet&)> forge;
  std::function<std::uint64_t(const Daemon&)> meanwhile{};  ///< how many it sent by itself
  std::function<void(RowRun&)> in_the_end{};
};

/// An attack during three seconds of pressing is rejected and counted, and not felt: never stale by
/// more than a hold, on UDP all along. `prepare` is called for each run.
void siege(const std::string& name, const std::function<Attack()>& prepare,
           const std::string& more = {}) {
  const std::string expected =
      "contract; engaged throughout; stays on UDP; forgeries rejected, by the server's counters" +
      more;
  network_row(name, expected, [&](RowRun& run) {
    const Attack attack = prepare();
    std::atomic<bool> attacking{false};
    std::atomic<std::uint64_t> forged{0};
    {
      RelaySetup setup = between(run.daemon());
      setup.attacker = [&](const Packet& packet) {
        auto packets = attack.forge(packet);
        if (!attacking) packets.clear();
        forged += packets.size();
        return packets;
      };
      const Relay relay(setup);
      Presser presser(run.daemon().behind_relay());
      if (!engages_by_udp(run, presser)) return;
      client::Connection server(run.daemon().address());
      const std::uint64_t before = rejected_datagrams(server);
      attacking = true;
      if (attack.meanwhile) forged += attack.meanwhile(run.daemon());
      std::this_thread::sleep_for(3s);
      attacking = false;
      expect_rejected(run, server, before, forged);
      run.expect(!presser.heard("SAMPLES UDP -> GRPC"), "UDP all along");
      run.insist(presser.in_order(), "a sequence in use that never goes back");
    }
    if (attack.in_the_end) attack.in_the_end(run);
    const RunFigures figures = run.judge();
    run.expect(figures.losses == 0, "force never lost", figures.last_loss);
    run.got(figures.text());
  });
}

TEST(NetworkRow, BitFlips) {
  siege("bit_flips", [] {
    const auto forge = [random = Random(3)](const Packet& packet) mutable {
      std::vector<Packet> damaged(3, packet);
      for (Packet& copy : damaged) {
        copy[random.next() % copy.size()] ^= static_cast<std::uint8_t>(1U << random.next() % 8);
      }
      return damaged;
    };
    return Attack{forge};
  });
}

TEST(NetworkRow, WrongKey) {
  siege("wrong_key", [] {
    const auto forger = std::make_shared<std::unique_ptr<wire::SecureChannel>>();
    const auto forge = [forger](const Packet& packet) {
      const wire::HeaderReading reading = wire::read_header(packet);
      if (!*forger) {
        wire::PathKeys guessed = wire::fresh_keys();
        guessed.path_id = reading.header.path_id;
        *forger = std::make_unique<wire::SecureChannel>(wire::End::kClient, guessed);
      }
      Packet forged(wire::kLargestDatagram);
      forged.resize((*forger)->seal(wire::DatagramType::kProxy, Packet(40, 0x11), forged));
      wire::put(reading.header.packet_number + 100, wire::Bytes(forged).subspan(8));
      return std::vector<Packet>{forged};
    };
    return Attack{forge};
  });
}

TEST(NetworkRow, ReplayedCapture) {
  siege("replayed_capture", [] {
    const auto forge = [capture = std::vector<Packet>{},
                        next = std::size_t{0}](const Packet& packet) mutable {
      capture.push_back(packet);
      return std::vector<Packet>{capture[next++ / 2]};  // ever older ones
    };
    return Attack{forge};
  });
}

/// A socket of an attacker's own: what it hears back.
class Stranger {
 public:
  Stranger() : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {}
  ~Stranger() { ::close(socket_); }
  Stranger(const Stranger&) = delete;
  Stranger& operator=(const Stranger&) = delete;
  /// False where the packet did not leave.
  [[nodiscard]] bool send(const Packet& packet, std::uint16_t port) const {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const ssize_t sent = ::sendto(socket_, packet.data(), packet.size(), 0,
                                  reinterpret_cast<const sockaddr*>(&to), sizeof to);
    return sent == static_cast<ssize_t>(packet.size());
  }
  [[nodiscard]] bool heard_anything() const {
    char byte = 0;
    return ::recv(socket_, &byte, 1, 0) >= 0;
  }

 private:
  int socket_;
};

/// Listens on the way, and sends what it heard from an address of its own.
struct Eavesdropper {
  Stranger stranger{};
  std::mutex mutex{};
  std::vector<Packet> seen{};
};

TEST(NetworkRow, SpoofedSource) {
  const auto prepare = [] {
    const auto ear = std::make_shared<Eavesdropper>();
    Attack attack;
    attack.forge = [ear](const Packet& packet) {
      const std::lock_guard lock(ear->mutex);
      ear->seen.push_back(packet);
      return std::vector<Packet>{};
    };
    attack.meanwhile = [ear](const Daemon& daemon) {
      // All through the siege, what came since the last look; the last 10 ms may still be on the
      // way.
      std::size_t next = 0;
      std::uint64_t sent = 0;
      const auto over = std::chrono::steady_clock::now() + 2s;
      while (std::chrono::steady_clock::now() < over) {
        {
          const std::lock_guard lock(ear->mutex);
          for (; next + 20 < ear->seen.size(); ++next) {
            sent += ear->stranger.send(ear->seen[next], daemon.udp_port()) ? 1 : 0;
          }
        }
        std::this_thread::sleep_for(10ms);
      }
      return sent;
    };
    attack.in_the_end = [ear](RowRun& run) {
      run.insist(!ear->stranger.heard_anything(), "no reply to the stranger");
    };
    return attack;
  };
  siege("spoofed_source", prepare, "; no reply to the stranger");
}

TEST(NetworkRow, ACutConnectionIsResumed) {
  network_row("cut_connection", "contract; resumed within the lease; force back by itself",
              [](RowRun& run) {
                {
                  auto relay = std::make_unique<Relay>(between(run.daemon(), "clean"));
                  Presser presser(run.daemon().behind_relay());
                  if (!engages_by_udp(run, presser)) return;
                  relay.reset();  // both carriers
                  relay = std::make_unique<Relay>(between(run.daemon(), "clean"));
                  run.expect(within(10s, [&] { return presser.heard("LEASE_RESUMED"); }),
                             "LEASE_RESUMED within 10 s");
                  run.expect(presser.session().lease_epoch() == 2U, "lease epoch 2");
                  engages_by_udp(run, presser);  // new keys, and a path of its own
                  run.insist(presser.in_order(), "a sequence in use that never goes back");
                }
                run.got(run.judge().text());
              });
}

/// The example client as a process behind the relay, watched past it. It asks for force again.
struct Wall {
  static constexpr double kRate = 200.0;  ///< Hz, the example's

  explicit Wall(const Daemon& daemon)
      : relay(between(daemon)),
        process(HAPTIC_BINARY_DIR "/client/haptic-example-virtual-wall",
                {"--server", daemon.behind_relay(), "--stop", "0.3"}),
        watching(daemon.address()),
        watch(watching.watch("finger", 100.0, [this](const client::DeviceState& state) {
          pressing = state.state == client::Lifecycle::kEngaged && state.gain == 1.0;
        })) {}

  /// The outcome is a finding of the run where it is not so.
  bool presses(RowRun& run) const {
    return run.expect(within(20s, [&] { return pressing.load(); }), "pressed within 20 s");
  }

  const Relay relay;
  Process process;
  client::Connection watching;
  std::atomic<bool> pressing{false};
  std::unique_ptr<client::Watch> watch;
};

/// Returns false where it never pressed.
bool kill_while_pressing(RowRun& run) {
  Wall wall(run.daemon());
  if (!wall.presses(run)) return false;
  wall.process.signal(SIGKILL);
  wall.process.wait();
  std::this_thread::sleep_for(3s);
  run.expect(wall.watching.devices().front().state == client::Lifecycle::kIdle, "IDLE 3 s later");
  return true;
}

TEST(NetworkRow, ClientKilled) {
  network_row("client_killed", "contract; no force and IDLE in the end", [](RowRun& run) {
    run.client_rate(Wall::kRate);
    if (!kill_while_pressing(run)) return;
    const RunFigures figures = run.judge();
    run.insist(run.record().back().tau_a == 0.0, "no force in the end");
    run.got(figures.text());
  });
}

/// Its exit status is 0 only where SIGTERM finds it alive and well.
TEST(NetworkRow, ClientStoppedFor300Ms) {
  network_row("client_stopped_300ms",
              "contract; a process stopped as a whole: lost, and engaged again; exit 0",
              [](RowRun& run) {
                run.client_rate(Wall::kRate);
                {
                  Wall wall(run.daemon());
                  if (!wall.presses(run)) return;
                  wall.process.signal(SIGSTOP);
                  std::this_thread::sleep_for(300ms);
                  wall.process.signal(SIGCONT);
                  run.expect(within(1s, [&] { return !wall.pressing; }), "no force after 300 ms");
                  if (!wall.presses(run)) return;
                  wall.process.signal(SIGTERM);
                  run.insist(wall.process.wait() == 0, "the client's exit status 0");
                }
                const RunFigures figures = run.judge();
                run.expect(figures.losses >= 1, "force lost");
                run.expect(figures.engages >= 2, "engaged again");
                run.got(figures.text());
              });
}

/// Only its samples: the library's threads go on.
TEST(NetworkRow, ClientPausedFor300Ms) {
  network_row("client_paused_300ms", "contract; lost once, and engaged again", [](RowRun& run) {
    {
      const Relay relay(between(run.daemon()));
      Presser presser(run.daemon().behind_relay());
      if (!engages_by_udp(run, presser)) return;
      presser.publishing = false;
      std::this_thread::sleep_for(300ms);
      presser.publishing = true;
      run.expect(within(5s, [&] { return presser.heard("LOST"); }), "LOST within 5 s");
      engages_again_by_udp(run, presser);
    }
    const RunFigures figures = run.judge();
    run.expect(figures.losses == 1, "force lost once", figures.last_loss);
    run.expect(figures.engages == 2, "engaged twice");
    run.got(figures.text());
  });
}

/// A number that no proxy may have: refused and counted, as good as silence, and force comes back
/// by a ramp.
void refuses(const std::string& name, double bad) {
  network_row(name, "contract; refused and counted; lost once, and engaged again",
              [bad](RowRun& run) {
                std::uint64_t refused = 0;
                {
                  const Relay relay(between(run.daemon()));
                  Presser presser(run.daemon().behind_relay());
                  if (!engages_by_udp(run, presser)) return;
                  presser.instead = &bad;
                  run.expect(within(5s, [&] { return presser.heard("LOST"); }), "LOST within 5 s");
                  presser.instead = nullptr;
                  engages_again_by_udp(run, presser);
                  refused = presser.session().statistics().rejected_invalid;
                }
                const RunFigures figures = run.judge();
                run.expect(figures.losses == 1, "force lost once", figures.last_loss);
                run.expect(figures.engages == 2, "engaged twice");
                // 180 ms at 100 Hz, but for what the way had under way
                run.expect(refused >= 15U, "15 refused or more");
                run.got(std::to_string(refused) + " refused");
                run.got(figures.text());
              });
}

TEST(NetworkRow, NotANumber) {
  refuses("nan", std::numeric_limits<double>::quiet_NaN());
}

TEST(NetworkRow, HugeValues) {
  refuses("huge_values", 1e300);
}

TEST(NetworkRow, SixteenObserversAt1Khz) {
  network_row("16_observers", "contract; engaged throughout beside 16 watchers", [](RowRun& run) {
    std::atomic<std::uint64_t> states{0};
    {
      client::Connection connection(run.daemon().address());
      std::vector<std::unique_ptr<client::Watch>> watches;
      for (int i = 0; i < 16; ++i) {
        watches.push_back(
            connection.watch("finger", 1000.0, [&](const client::DeviceState&) { ++states; }));
      }
      Presser presser(run.daemon().address());
      const auto engaged = [&] { return presser.state().state == client::Lifecycle::kEngaged; };
      if (!run.expect(within(20s, engaged), "engaged within 20 s")) return;
      std::this_thread::sleep_for(4s);
    }
    const RunFigures figures = run.judge();
    run.expect(figures.losses == 0, "force never lost", figures.last_loss);
    run.expect(states > 16'000U, "1000 states to each observer, or more");
    run.got(std::to_string(states) + " states to them");
    run.got(figures.text());
  });
}

TEST(NetworkRow, SigtermUnderLoad) {
  network_row("sigterm_under_load", "contract; CLOSING without force; exit 0 within 5 s",
              [](RowRun& run) {
                const Relay relay(between(run.daemon(), "loss_05"));
                Presser presser(run.daemon().behind_relay());
                if (!engages_by_udp(run, presser)) return;
                const auto before = std::chrono::steady_clock::now();
                static_cast<void>(run.record());
                run.insist(std::chrono::steady_clock::now() - before < 5s, "the end within 5 s");
                const RunFigures figures = run.judge();
                run.insist(figures.last_state == "CLOSING", "CLOSING in the end");
                run.insist(run.record().back().tau_a == 0.0, "no force in the end");
                run.got(figures.text());
              });
}

}  // namespace
}  // namespace haptic::test
