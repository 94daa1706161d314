#include "tests/relay/virtual_world.hpp"

#include <bit>
#include <cmath>

namespace haptic::test {
namespace {

double slow_press(LinkTime time) {
  return 0.01 + 0.002 * std::sin(std::chrono::duration<double>(time).count() * 6.0);
}

wire::PathRules path_rules() {
  wire::PathRules rules;
  rules.nominal_period = VirtualWorld::kSamplePeriod;
  return rules;
}

}  // namespace

Packet packed_sample(std::uint64_t seq, double a) {
  Packet packet(16);
  wire::put(seq, packet);
  wire::put(std::bit_cast<std::uint64_t>(a), wire::Bytes(packet).subspan(8));
  return packet;
}

Scenario shipped_scenario(const std::string& name) {
  return read_scenario(HAPTIC_SOURCE_DIR "/tests/relay/scenarios/" + name + ".textproto");
}

VirtualWorld::VirtualWorld(const Scenario& which)
    : scenario(which),
      udp_up(which.up, which.seed, haptic::test::Carrier::kUdp),
      udp_down(which.down, which.seed + 1000, haptic::test::Carrier::kUdp),
      stream_up(which.up, which.seed + 2000),
      client({wire::End::kClient, keys, path_rules(),
              [this](const wire::PeerAddress&, wire::ConstBytes datagram) {
                Packet packet(datagram.begin(), datagram.end());
                if (on_wire) on_wire(packet);
                udp_up.send(std::move(packet), time());
              },
              [random = Random(1)]() mutable { return random.next(); }}),
      server({wire::End::kServer, keys, path_rules(),
              [this](const wire::PeerAddress& to, wire::ConstBytes datagram) {
                answered.push_back(to);
                if (to == server_sees) udp_down.send({datagram.begin(), datagram.end()}, time());
              },
              [random = Random(2)]() mutable { return random.next(); }}),
      proxy(slow_press) {
  server::LeaseRequest request;
  request.session_id = "s1";
  request.client_name = "alice";
  request.nominal_rate_hz = 100.0;
  rig.tick(3);
  rig.sessions->open_controller(request, rig.now,
                                [this](const server::Outcome<server::Lease>& outcome) {
                                  if (outcome) lease = *outcome.value;
                                });
  rig.tick(10);
  began = rig.now;
  client.start(client_sees, client_reading());
}

wire::TimePoint VirtualWorld::client_reading() const {
  return to_wire(kStart + client_clock(scenario.client_clock, time()));
}

wire::Rejection VirtualWorld::deliver(wire::ConstBytes datagram, const wire::PeerAddress& from) {
  const wire::HeaderReading reading = wire::read_header(datagram);  // the port's own checks
  if (reading.rejection != wire::Rejection::kNone) return reading.rejection;
  if (reading.header.path_id != keys.path_id) return wire::Rejection::kUnknownPath;
  const auto received = server.receive(datagram, from, to_wire(rig.now));
  if (received.message) accept(*received.message, server::Carrier::kUdp);
  return received.rejection;
}

void VirtualWorld::step() {
  while (auto packet = udp_up.receive(time())) {
    static_cast<void>(deliver(packet->second, server_sees));
  }
  while (auto packet = stream_up.receive(time())) accept(packet->second, server::Carrier::kGrpc);
  while (auto packet = udp_down.receive(time())) {
    if (!alive) continue;
    on_client_change(client.receive(packet->second, client_sees, client_reading()).change);
  }
  if (alive) on_client_change(client.step(client_reading()));
  static_cast<void>(server.step(to_wire(rig.now)));
  if (time() >= next_sample) publish();
  if (alive && rig.state() == core::DeviceState::kArmed && time() % 50ms == 0ms) {
    static_cast<void>(rig.sessions->engage("s1", [](const auto&) {}));
  }
  rig.tick();
}

void VirtualWorld::publish() {
  next_sample += kSamplePeriod;
  if (!alive || !publishing) return;
  newest = packed_sample(++seq, proxy(time()));
  if (!client.send(newest)) stream_up.send(newest, time());
}

void VirtualWorld::on_client_change(wire::PathChange change) {
  if (change == wire::PathChange::kSilent || change == wire::PathChange::kLossy) {
    ++fallbacks;
    stream_up.send(newest, time());
  }
}

void VirtualWorld::accept(wire::ConstBytes bytes, server::Carrier carrier) {
  const double position[2] = {std::bit_cast<double>(wire::get_u64(bytes.subspan(8))), 0.0};
  server::ProxyCandidate candidate;
  candidate.epoch = lease.epoch;
  candidate.seq = wire::get_u64(bytes);
  candidate.mode = core::ProxyMode::kHeld;
  candidate.position = position;
  candidate.position_size = 2;
  candidate.carrier = carrier;
  const auto verdict = rig.sessions->ingress().accept(candidate, rig.now);
  if (verdict == server::IngressVerdict::kAccepted || verdict == server::IngressVerdict::kBacklog) {
    last_accepted = rig.now;
    ++accepted;
  }
}

}  // namespace haptic::test
