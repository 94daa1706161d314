#include "haptic/core/tick/tick_record.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

namespace haptic::core {

namespace {

bool same(double a, double b) noexcept {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

template <typename Vector>
bool same_bits(const Vector& a, const Vector& b) noexcept {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

bool identical(const DeviceReading& a, const DeviceReading& b) noexcept {
  return a.fresh == b.fresh && a.armed == b.armed && a.health == b.health &&
         a.sample.seq == b.sample.seq && a.sample.time == b.sample.time &&
         same_bits(a.sample.q, b.sample.q) &&
         same_bits(a.sample.tau_measured, b.sample.tau_measured);
}

bool identical(const ProxySnapshot& a, const ProxySnapshot& b) noexcept {
  return a.mode == b.mode && a.tenure == b.tenure && a.seq == b.seq && a.born == b.born &&
         a.valid_for == b.valid_for && same_bits(a.x, b.x) &&
         same_bits(a.planes.normals, b.planes.normals) &&
         same_bits(a.planes.offsets, b.planes.offsets) && a.gapless_since == b.gapless_since &&
         a.gapless_samples == b.gapless_samples;
}

bool identical(const TrackerSnapshot& a, const TrackerSnapshot& b) noexcept {
  return a.seq == b.seq && a.born == b.born && a.valid_for == b.valid_for &&
         a.staleness == b.staleness &&
         std::equal(a.pose.begin(), a.pose.end(), b.pose.begin(), same);
}

bool identical(const TrackerRecord& a, const TrackerRecord& b) noexcept {
  return a.on == b.on && a.first_dof == b.first_dof && a.seq == b.seq && a.level == b.level &&
         a.age == b.age && same(a.ladder, b.ladder) && a.hold_end == b.hold_end;
}

bool identical(const CommandSnapshot& a, const CommandSnapshot& b) noexcept {
  return a.tenure == b.tenure && a.lease_held == b.lease_held && a.engage_id == b.engage_id &&
         a.release_id == b.release_id && a.stop_id == b.stop_id && a.clear_id == b.clear_id &&
         a.clear == b.clear && a.clear_stop_id == b.clear_stop_id && a.closing == b.closing;
}

bool identical(const RenderSettings& a, const RenderSettings& b) noexcept {
  return a.id == b.id && a.renderer == b.renderer && a.direction_guard == b.direction_guard &&
         same_bits(a.stiffness, b.stiffness) && same_bits(a.damping, b.damping) &&
         same_bits(a.force_limit, b.force_limit) && same_bits(a.slew_limit, b.slew_limit) &&
         same_bits(a.engage_window, b.engage_window) && a.staleness == b.staleness;
}

bool identical(const TickInput& a, const TickInput& b) noexcept {
  return a.now == b.now && a.period == b.period && a.loop.lateness == b.loop.lateness &&
         a.loop.skipped == b.loop.skipped && identical(a.device, b.device) &&
         identical(a.proxy, b.proxy) && identical(a.tracker, b.tracker) &&
         identical(a.command, b.command) && identical(a.settings, b.settings);
}

bool identical(const Certificate& a, const Certificate& b) noexcept {
  return a.status == b.status && a.block == b.block && same(a.margin, b.margin);
}

bool identical(const EngageAnswer& a, const EngageAnswer& b) noexcept {
  return a.id == b.id && a.verdict == b.verdict && a.index == b.index && same(a.value, b.value) &&
         same(a.limit, b.limit);
}

bool identical(const PassivityRecord& a, const PassivityRecord& b) noexcept {
  return a.on == b.on && same(a.storage, b.storage) && same(a.injected, b.injected) &&
         same(a.scale, b.scale) && a.throttled == b.throttled && same(a.tank, b.tank) &&
         same(a.hold.leak, b.hold.leak) && same(a.hold.limits, b.hold.limits) &&
         same(a.hold.rendered, b.hold.rendered) &&
         same(a.hold.device_damping, b.hold.device_damping) && same(a.observed, b.observed) &&
         same(a.alpha, b.alpha);
}

bool identical(const Beat& a, const Beat& b) noexcept {
  return a.tick == b.tick && a.dt == b.dt && a.faults == b.faults;
}

bool identical(const Sensed& a, const Sensed& b) noexcept {
  return same_bits(a.q, b.q) && same_bits(a.q_a_dot, b.q_a_dot) &&
         same_bits(a.tau_measured, b.tau_measured) && identical(a.tracker, b.tracker) &&
         a.ready == b.ready && a.fresh == b.fresh && a.recent == b.recent && a.silent == b.silent &&
         a.age == b.age && a.faults == b.faults;
}

bool identical(const ProxyInUse& a, const ProxyInUse& b) noexcept {
  return a.mode == b.mode && a.seq == b.seq && a.age == b.age && a.level == b.level &&
         same(a.ladder, b.ladder) && a.gapless_since == b.gapless_since &&
         a.gapless_samples == b.gapless_samples;
}

bool identical(const Anchor& a, const Anchor& b) noexcept {
  return same_bits(a.x_probe, b.x_probe) && same_bits(a.x, b.x) && a.free == b.free &&
         a.mapped == b.mapped && a.in_the_way == b.in_the_way && a.planes == b.planes &&
         a.active_planes == b.active_planes && a.anchored == b.anchored &&
         same_bits(a.q_star, b.q_star) && a.projection == b.projection &&
         same(a.residual, b.residual) && same(a.condition, b.condition) &&
         identical(a.certificate, b.certificate) && a.limiters == b.limiters;
}

bool identical(const Lifecycle& a, const Lifecycle& b) noexcept {
  return a.state == b.state && a.lost == b.lost && a.faults == b.faults && a.arm == b.arm &&
         a.engaged == b.engaged && identical(a.engage, b.engage) && a.release_id == b.release_id &&
         a.stop_id == b.stop_id && a.clear.id == b.clear.id && a.clear.refused == b.clear.refused &&
         same(a.gain, b.gain) && same(a.damping_gain, b.damping_gain);
}

bool identical(const Effort& a, const Effort& b) noexcept {
  return same_bits(a.q_star, b.q_star) && same_bits(a.tau_elastic, b.tau_elastic) &&
         same_bits(a.tau_damping, b.tau_damping) && same_bits(a.tau_a, b.tau_a) &&
         a.limiters == b.limiters && a.actuator_limiters == b.actuator_limiters &&
         same_bits(a.temperature_c, b.temperature_c) && same_bits(a.drive, b.drive) &&
         same_bits(a.position, b.position) && identical(a.passivity, b.passivity) &&
         a.faults == b.faults;
}

}  // namespace

bool identical(const TickRecord& a, const TickRecord& b) noexcept {
  return identical(a.input, b.input) && identical(a.beat, b.beat) &&
         a.settings_id == b.settings_id && identical(a.sensed, b.sensed) &&
         identical(a.proxy, b.proxy) && identical(a.anchor, b.anchor) &&
         identical(a.life, b.life) && identical(a.effort, b.effort);
}

}  // namespace haptic::core
