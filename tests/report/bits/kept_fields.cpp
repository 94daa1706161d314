#include "tests/report/bits/kept_fields.hpp"

#include <bit>

namespace haptic::report {
namespace {

using core::TickRecord;

void put(Words& to, double value) {
  to.push_back(std::bit_cast<std::uint64_t>(value));
}
template <typename Vector>
void put(Words& to, const Eigen::PlainObjectBase<Vector>& values) {
  to.push_back(static_cast<std::uint64_t>(values.size()));
  for (Eigen::Index i = 0; i < values.size(); ++i) put(to, values.coeff(i));
}
void put(Words& to, core::Duration value) {
  to.push_back(static_cast<std::uint64_t>(value.count()));
}
/// A set of faults or limiters.
template <typename Set>
auto put(Words& to, Set set) -> decltype(to.push_back(set.bits())) {
  to.push_back(set.bits());
}
/// A whole number, an enumerator or a bool.
template <typename T>
requires(std::is_integral_v<T> || std::is_enum_v<T>) void put(Words& to, T value) {
  to.push_back(static_cast<std::uint64_t>(value));
}
template <typename... T>
void put_all(Words& to, const T&... values) {
  (put(to, values), ...);
}

constexpr KeptField kFields[] = {
    {"q", false, [](const TickRecord& t, Words& to) { put(to, t.sensed.q); }},
    {"q_a_dot", false, [](const TickRecord& t, Words& to) { put(to, t.sensed.q_a_dot); }},
    {"tau_measured", false, [](const TickRecord& t, Words& to) { put(to, t.sensed.tau_measured); }},
    {"device_age", false,
     [](const TickRecord& t, Words& to) {
       put_all(to, t.sensed.fresh, t.sensed.recent, t.sensed.silent, t.sensed.age);
     }},
    {"tracker", false,
     [](const TickRecord& t, Words& to) {
       put_all(to, t.sensed.tracker.seq, t.sensed.tracker.level, t.sensed.tracker.ladder);
     }},
    {"staleness", false,
     [](const TickRecord& t, Words& to) {
       put_all(to, t.proxy.mode, t.proxy.seq, t.proxy.age, t.proxy.level, t.proxy.ladder);
     }},
    {"derating", false,
     [](const TickRecord& t, Words& to) {
       put_all(to, t.derating.reason, t.derating.delay, t.derating.stiffness);
     }},
    {"x_probe", false, [](const TickRecord& t, Words& to) { put(to, t.anchor.x_probe); }},
    {"x", false, [](const TickRecord& t, Words& to) { put(to, t.anchor.x); }},
    {"planes", false,
     [](const TickRecord& t, Words& to) {
       put_all(to, t.anchor.free, t.anchor.mapped, t.anchor.in_the_way, t.anchor.planes,
               t.anchor.active_planes);
     }},
    {"contact_energy", false,
     [](const TickRecord& t, Words& to) { put_all(to, t.anchor.stored, t.anchor.coupling); }},
    {"unexplained", false, [](const TickRecord& t, Words& to) { put(to, t.anchor.unexplained); }},
    {"projection", false,
     [](const TickRecord& t, Words& to) {
       put_all(to, t.anchor.anchored, t.anchor.projection, t.anchor.residual, t.anchor.condition);
     }},
    {"q_star_wanted", false, [](const TickRecord& t, Words& to) { put(to, t.anchor.q_star); }},
    {"state", true,
     [](const TickRecord& t, Words& to) {
       put_all(to, t.life.state, t.life.lost, t.life.arm, t.life.engaged);
     }},
    {"engage", false,
     [](const TickRecord& t, Words& to) {
       put_all(to, t.life.engage.id, t.life.engage.verdict, t.life.engage.value,
               t.life.engage.limit);
     }},
    {"gain", true,
     [](const TickRecord& t, Words& to) { put_all(to, t.life.gain, t.life.damping_gain); }},
    {"q_star", true, [](const TickRecord& t, Words& to) { put(to, t.effort.q_star); }},
    {"energy", false,
     [](const TickRecord& t, Words& to) {
       const core::PassivityRecord& account = t.effort.passivity;
       put_all(to, account.storage, account.injected, account.scale, account.throttled,
               account.tank, account.observed, account.alpha);
     }},
    {"tau_elastic", true, [](const TickRecord& t, Words& to) { put(to, t.effort.tau_elastic); }},
    {"tau_damping", true, [](const TickRecord& t, Words& to) { put(to, t.effort.tau_damping); }},
    {"tau_a", true, [](const TickRecord& t, Words& to) { put(to, t.effort.tau_a); }},
    {"drive", true,
     [](const TickRecord& t, Words& to) { put_all(to, t.effort.drive, t.effort.position); }},
    {"temperature", false, [](const TickRecord& t, Words& to) { put(to, t.effort.temperature_c); }},
    {"error_bound", false, [](const TickRecord& t, Words& to) { put(to, t.effort.error_bound); }},
    {"limiters", false,
     [](const TickRecord& t, Words& to) {
       put(to, t.limiters());
       for (int i = 0; i < t.effort.tau_a.size(); ++i) {
         put(to, t.effort.actuator_limiters[static_cast<std::size_t>(i)]);
       }
     }},
    {"faults", true, [](const TickRecord& t, Words& to) { put(to, t.faults()); }},
};

}  // namespace

std::span<const KeptField> kept_fields() {
  return kFields;
}

void Chain::add(const Words& words) noexcept {
  for (const std::uint64_t word : words) {
    // The finaliser of SplitMix64 (Steele, Lea, Flood 2014).
    std::uint64_t z = (value_ ^ word) + 0x9E3779B97F4A7C15U;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    value_ = z ^ (z >> 31U);
  }
}

RunHashes::RunHashes() : fields_(kept_fields().size()) {}

void RunHashes::add(const core::TickRecord& record) {
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    const KeptField& field = kept_fields()[i];
    words_.clear();
    field.write(record, words_);
    fields_[i].add(words_);
    if (field.force) force_.add(words_);
  }
  if (++ticks_ % kBlock == 0) blocks_.push_back(force_.value());
}

}  // namespace haptic::report
