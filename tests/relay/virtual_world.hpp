#pragma once
/// A client of 100 Hz that presses, and a server, on virtual time: the shipped wire, ingress, sessions
/// and pipeline with a scenario's link between them; over UDP where the path is in use, else over a
/// stream.

#include <functional>
#include <vector>

#include "haptic/wire/path_end.hpp"
#include "tests/server/support/device_rig.hpp"
#include "tests/support/link/impaired_link.hpp"

namespace haptic::test {

[[nodiscard]] inline wire::TimePoint to_wire(core::TimePoint time) {
  return wire::TimePoint(time.time_since_epoch());
}

struct VirtualWorld {
  static constexpr LinkTime kSamplePeriod = 10ms;
  static constexpr double kSlewPerTick = 1000.0 * 1e-3;  // rig_config(), N
  static constexpr core::TimePoint kStart{1h};

  explicit VirtualWorld(const Scenario& which);
  VirtualWorld(const VirtualWorld&) = delete;
  VirtualWorld& operator=(const VirtualWorld&) = delete;

  /// Since the session opened.
  [[nodiscard]] LinkTime time() const { return rig.now - began; }
  /// One millisecond: what arrived, the client's step, a tick.
  void step();
  void run(LinkTime until) {
    while (time() < until) step();
  }
  /// What reaches the server's socket; also what an attacker sends.
  wire::Rejection deliver(wire::ConstBytes datagram, const wire::PeerAddress& from);
  [[nodiscard]] double force() const { return rig.newest().tau_a[0]; }

  const Scenario scenario;
  wire::PathKeys keys = wire::fresh_keys();
  wire::PeerAddress client_sees{{}, 1}, server_sees{{}, 2};
  DeviceRig rig{rig_config(), {}, kStart};
  core::TimePoint began{}, last_accepted{};
  server::Lease lease{};
  ImpairedLink udp_up, udp_down;
  ReliableLink stream_up;
  wire::PathEnd client, server;
  LinkTime next_sample{0};
  std::uint64_t seq{0}, accepted{0};
  Packet newest{};
  int fallbacks{0};
  bool alive{true};       ///< false: the client does nothing any more
  bool publishing{true};  ///< false: its simulation stands still, its transport lives
  std::vector<wire::PeerAddress> answered{};  ///< whom the server sent anything, in order
  /// Of a sample's first coordinate, m, at a time; by default a slow press.
  std::function<double(LinkTime)> proxy{};
  /// Sees every datagram of the client, and may change it.
  std::function<void(Packet&)> on_wire{};

 private:
  [[nodiscard]] wire::TimePoint client_reading() const;
  void publish();
  void on_client_change(wire::PathChange change);
  void accept(wire::ConstBytes bytes, server::Carrier carrier);
};

/// A sample as these tests put it into a datagram; what protobuf does is tested elsewhere.
[[nodiscard]] Packet packed_sample(std::uint64_t seq, double a);

[[nodiscard]] Scenario shipped_scenario(const std::string& name);

}  // namespace haptic::test
