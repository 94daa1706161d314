#include "tests/relay/virtual_world.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace haptic::test {
namespace {

constexpr double kWall = -0.002;     // m
constexpr double kCompliance = 3.0;  // of 100 N/m

double slow_press(LinkTime time) {
  return 0.01 + 0.002 * std::sin(std::chrono::duration<double>(time).count() * 6.0);
}

/// In and out of the spring, one and a half times a second.
double slow_hand(LinkTime time) {
  return 0.005 * std::sin(std::chrono::duration<double>(time).count() * 3.0 * M_PI);
}

core::PipelineConfig world_config() {
  core::PipelineConfig config = rig_config();
  config.passivity.device_damping = core::VecA::Constant(1, VirtualWorld::kDeviceDamping);
  config.passivity.tank.enabled = true;
  config.passivity.tank.initial = config.passivity.tank.capacity = VirtualWorld::kTank;
  return config;
}

wire::PathRules path_rules(LinkTime period) {
  wire::PathRules rules;
  rules.nominal_period = period;
  return rules;
}

}  // namespace

Packet packed_sample(std::uint64_t seq, double a, const SampleTimes& times) {
  Packet packet(40);
  const wire::Bytes bytes(packet);
  wire::put(seq, bytes);
  wire::put(std::bit_cast<std::uint64_t>(a), bytes.subspan(8));
  wire::put(static_cast<std::uint64_t>(times.source_time_ns), bytes.subspan(16));
  wire::put(times.state_used, bytes.subspan(24));
  wire::put(static_cast<std::uint64_t>(times.hold_ns), bytes.subspan(32));
  return packet;
}

VirtualWorld::VirtualWorld(const Scenario& which, LinkTime period)
    : scenario(which),
      sample_period(period),
      rig(world_config(), {}, kStart),
      udp_up(which.up, which.seed, haptic::test::Carrier::kUdp),
      udp_down(which.down, which.seed + 1000, haptic::test::Carrier::kUdp),
      stream_up(which.up, which.seed + 2000),
      stream_down(which.down, which.seed + 3000),
      client({wire::End::kClient, keys, path_rules(period),
              [this](const wire::PeerAddress&, wire::ConstBytes datagram) {
                Packet packet(datagram.begin(), datagram.end());
                if (on_wire) on_wire(packet);
                udp_up.send(std::move(packet), time());
              },
              [random = Random(1)]() mutable { return random.next(); }}),
      server({wire::End::kServer, keys, path_rules(period),
              [this](const wire::PeerAddress& to, wire::ConstBytes datagram) {
                answered.push_back(to);
                if (to == server_sees) udp_down.send({datagram.begin(), datagram.end()}, time());
              },
              [random = Random(2)]() mutable { return random.next(); }}) {
  server::LeaseRequest request;
  request.session_id = "s1";
  request.client_name = "alice";
  request.nominal_rate_hz = 1.0 / std::chrono::duration<double>(period).count();
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
  step_client();
  static_cast<void>(server.step(to_wire(rig.now)));
  if (time() >= next_sample) publish();
  if (rig.state() == core::LifecycleState::kArmed && time() % 50ms == 0ms) {
    static_cast<void>(rig.sessions->engage("s1", [](const auto&) {}));
  }
  rig.device->q[0] = slow_hand(time());
  rig.tick();
  if (time() >= next_state) send_state();
}

void VirtualWorld::step_client() {
  const bool knew = client.in_doubt();
  const auto fell_back = [](wire::PathChange change) {
    return change == wire::PathChange::kSilent || change == wire::PathChange::kLossy;
  };
  int lost = 0;
  while (auto packet = udp_down.receive(time())) {
    const auto received = client.receive(packet->second, client_sees, client_reading());
    if (received.message) take_state(*received.message);
    lost += fell_back(received.change) ? 1 : 0;
  }
  while (auto packet = stream_down.receive(time())) {
    take_state(packet->second);
  }
  lost += fell_back(client.step(client_reading())) ? 1 : 0;
  fallbacks += lost;
  // Does what the client library does: what may be lost goes by the stream, under the number it
  // has.
  if (knew || (lost == 0 && !client.in_doubt())) return;
  stream_up.send(newest, time());
}

void VirtualWorld::take_state(wire::ConstBytes state) {
  const std::uint64_t tick = wire::get<std::uint64_t>(state);
  if (tick <= state_used_) return;
  state_used_ = tick;
  probe_used_ = std::bit_cast<double>(wire::get<std::uint64_t>(state.subspan(8)));
  state_came_ = client_reading();
}

void VirtualWorld::send_state() {
  next_state += kStatePeriod;
  const std::uint64_t tick = rig.newest().beat.tick;
  Packet state(16);
  wire::put(tick, state);
  wire::put(std::bit_cast<std::uint64_t>(rig.newest().sensed.q[0]), wire::Bytes(state).subspan(8));
  const bool by_udp = server.send(state);
  if (!by_udp) stream_down.send(state, time());
  link.state_sent(tick, rig.now, by_udp ? server::Carrier::kUdp : server::Carrier::kGrpc);
}

void VirtualWorld::publish() {
  next_sample += sample_period;
  const wire::TimePoint reading = client_reading();
  const double beyond = std::max(0.0, probe_used_ - kWall);
  const double x = contacts ? probe_used_ - beyond / (1.0 + kCompliance) : slow_press(time());
  newest = packed_sample(
      ++seq, x, {reading.time_since_epoch().count(), state_used_, (reading - state_came_).count()});
  ways[seq].published = rig.now;
  const bool by_udp = client.send(newest);
  if (by_udp && !client.in_doubt()) return;
  stream_up.send(newest, time());
}

void VirtualWorld::accept(wire::ConstBytes bytes, server::Carrier carrier) {
  const std::optional<server::Departure> left = link.came(
      {carrier, bytes.size(),
       static_cast<std::int64_t>(wire::get<std::uint64_t>(bytes.subspan(16))),
       wire::get<std::uint64_t>(bytes.subspan(24)),
       core::Duration(static_cast<std::int64_t>(wire::get<std::uint64_t>(bytes.subspan(32)))),
       rig.now},
      server.clock_offset().at(to_wire(rig.now)));
  server::ProxySample sample;
  sample.epoch = lease.epoch;
  sample.seq = wire::get<std::uint64_t>(bytes);
  // Free at first: the finger comes from outside.
  sample.mode = sample.seq <= 10 ? core::ProxyMode::kFree : core::ProxyMode::kHeld;
  if (contacts && sample.mode == core::ProxyMode::kHeld) {
    sample.mode = core::ProxyMode::kPlanes;
    sample.plane_count = 1;
    sample.planes[0] = {{1.0, 0.0}, kWall, kCompliance};
    sample.planes[0].id = 1;
    sample.tick_used = wire::get<std::uint64_t>(bytes.subspan(24));
  }
  sample.position = {std::bit_cast<double>(wire::get<std::uint64_t>(bytes.subspan(8))), 0.0};
  sample.carrier = carrier;
  sample.left = left;
  sample.arrival = rig.now;
  const server::Verdict verdict = rig.owner->accept(sample);
  if (verdict.used()) {
    last_accepted = rig.now;
    ++accepted;
    ways[sample.seq].accepted = rig.now;
    ways[sample.seq].backlog = verdict.verdict == server::IngressVerdict::kBacklog;
  }
}

}  // namespace haptic::test
