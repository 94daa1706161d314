#pragma once
/// A client that presses, and a server whose device a hand moves, on virtual time: the shipped
/// wire, link watch, ingress, sessions and pipeline with a scenario's link between them, samples up
/// and states down; over UDP if the path is in use, otherwise over a stream.

#include <functional>
#include <map>
#include <vector>

#include "haptic/wire/path_end.hpp"
#include "server/front/session/link_watch.hpp"
#include "tests/server/support/device_rig.hpp"
#include "tests/support/link/impaired_link.hpp"

namespace haptic::test {

[[nodiscard]] inline wire::TimePoint to_wire(core::TimePoint time) {
  return wire::TimePoint(time.time_since_epoch());
}

struct VirtualWorld {
  static constexpr LinkTime kSamplePeriod = 10ms;
  static constexpr LinkTime kStatePeriod = 10ms;
  static constexpr double kSlewPerTick = 1000.0 * 1e-3;  // rig_config(), N
  static constexpr double kTank = 0.005;                 // J, at every Engage
  static constexpr double kDeviceDamping = 0.5;          // N s/m, what is known of it
  static constexpr core::TimePoint kStart{1h};

  explicit VirtualWorld(const Scenario& which, LinkTime sample_period = kSamplePeriod);
  VirtualWorld(const VirtualWorld&) = delete;
  VirtualWorld& operator=(const VirtualWorld&) = delete;

  /// Since the session opened.
  [[nodiscard]] LinkTime time() const { return rig.now - began; }
  /// One millisecond: what arrived, the client's step, a tick.
  void step();
  void run(LinkTime until) {
    while (time() < until) step();
  }
  /// Datagrams that reach the server's socket; also what an attacker sends.
  wire::Rejection deliver(wire::ConstBytes datagram, const wire::PeerAddress& from);
  [[nodiscard]] double force() const { return rig.newest().effort.tau_a[0]; }

  /// When a sample was published and accepted, by the server's clock.
  struct Way {
    core::TimePoint published{}, accepted{};
    bool backlog{false};
  };

  const Scenario scenario;
  const LinkTime sample_period;
  wire::PathKeys keys = wire::fresh_keys();
  wire::PeerAddress client_sees{{}, 1}, server_sees{{}, 2};
  DeviceRig rig;
  core::TimePoint began{}, last_accepted{};
  server::Lease lease{};
  ImpairedLink udp_up, udp_down;
  ReliableLink stream_up, stream_down;
  server::LinkWatch link{};
  wire::PathEnd client, server;
  LinkTime next_sample{0}, next_state{0};
  std::uint64_t seq{0}, accepted{0};
  Packet newest{};
  std::map<std::uint64_t, Way> ways{};  ///< by the sample's number
  int fallbacks{0};
  /// True: it tells a soft wall as a contact, in the way of the hand (in and out by 3 mm), and its
  /// own proxy in every sample. False: a held proxy that presses slowly.
  bool contacts{false};
  std::vector<wire::PeerAddress> answered{};  ///< whom the server sent anything, in order
  /// Sees every datagram of the client, and may change it.
  std::function<void(Packet&)> on_wire{};

 private:
  [[nodiscard]] wire::TimePoint client_reading() const;
  void publish();
  void send_state();
  void take_state(wire::ConstBytes state);
  void step_client();
  void accept(wire::ConstBytes bytes, server::Carrier carrier);

  std::uint64_t state_used_{0};  ///< the client's newest state, and when it came by its clock
  wire::TimePoint state_came_{};
  double probe_used_{0.0};  ///< its first coordinate, m
};

/// The times in a sample, on the client's clock (ProxySample).
struct SampleTimes {
  std::int64_t source_time_ns{0};
  std::uint64_t state_used{0};
  std::int64_t hold_ns{0};
};
/// A sample as these tests put it into a datagram; the protobuf message is tested elsewhere.
[[nodiscard]] Packet packed_sample(std::uint64_t seq, double a, const SampleTimes& times = {});

}  // namespace haptic::test
