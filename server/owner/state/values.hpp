#pragma once
/// How values of a tick's record become values of v1::DeviceState, and those that are no member of
/// the record: the functions that the option (from) calls "owner.NAME".

#include <algorithm>
#include <chrono>
#include <vector>

#include "google/protobuf/repeated_field.h"
#include "server/owner/state/state_message.hpp"

namespace haptic::server {

template <typename Number>
requires std::is_arithmetic_v<Number> Number plain(Number value) {
  return value;
}
template <typename Enum>
std::uint32_t plain(core::BitSet32<Enum> set) {
  return set.bits();
}
/// Whole microseconds, from 0 on.
inline std::uint64_t plain(core::Duration age) {
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(age).count();
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, us));
}
/// Nanoseconds of the steady clock.
inline std::int64_t plain(core::TimePoint time) {
  return time.time_since_epoch().count();
}

template <typename Vector, typename Number>
void put(const Vector& from, google::protobuf::RepeatedField<Number>& to) {
  to.Clear();
  to.Add(from.data(), from.data() + from.size());
}

inline Carrier carrier(const TickTold& told) {
  return told.carrier;
}
inline std::uint32_t lease_epoch(const TickTold& told) {
  return told.lease_epoch;
}

/// g K: as derated, or the settings'.
inline core::VecA stiffness_in_effect(const TickTold& told) {
  const core::TickRecord& record = told.record;
  const bool derated = record.derating.reason != core::DeratingReason::kNone;
  return record.life.gain * (derated ? record.derating.stiffness : record.input.settings.stiffness);
}

inline const core::VecA& drive(const TickTold& told) {
  const core::Effort& effort = told.record.effort;
  return effort.drive.size() > 0 ? effort.drive : effort.position;
}

/// The reading of the device, if it was refused.
inline core::VecQ refused_reading(const TickTold& told) {
  const core::Sensed& sensed = told.record.sensed;
  const core::VecQ& reading = told.record.input.device.sample.q;
  return sensed.refused && reading.size() == sensed.q.size() ? reading : core::VecQ{};
}

/// One per actuated DoF, or none if none acted.
inline std::vector<std::uint32_t> actuator_limiters(const TickTold& told) {
  const core::Effort& effort = told.record.effort;
  const auto begin = effort.actuator_limiters.begin();
  const auto end = begin + effort.tau_a.size();
  if (std::none_of(begin, end, [](core::LimiterSet set) { return set.any(); })) return {};
  std::vector<std::uint32_t> bits;
  for (auto set = begin; set != end; ++set) bits.push_back(set->bits());
  return bits;
}

}  // namespace haptic::server
