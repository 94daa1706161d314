#include "convert.hpp"

#include "convert_state.hpp"
#include "google/protobuf/util/time_util.h"

namespace haptic::client {

namespace {

using google::protobuf::util::TimeUtil;

std::vector<double> to_vector(const google::protobuf::RepeatedField<double>& field) {
  return {field.begin(), field.end()};
}

}  // namespace

DeviceState to_state(const v1::DeviceState& message) {
  DeviceState state;
  read(message, state);
  state.received = std::chrono::steady_clock::now();
  return state;
}

std::chrono::nanoseconds to_duration(const google::protobuf::Duration& message) {
  return std::chrono::nanoseconds(TimeUtil::DurationToNanoseconds(message));
}

void write(std::chrono::nanoseconds from, google::protobuf::Duration& to) {
  to = TimeUtil::NanosecondsToDuration(from.count());
}

v1::UpdateSettingsRequest to_request(const Settings& settings) {
  v1::UpdateSettingsRequest m;
  m.mutable_stiffness()->Add(settings.stiffness.begin(), settings.stiffness.end());
  m.mutable_damping()->Add(settings.damping.begin(), settings.damping.end());
  m.mutable_force_limit()->Add(settings.force_limit.begin(), settings.force_limit.end());
  m.mutable_slew_limit()->Add(settings.slew_limit.begin(), settings.slew_limit.end());
  m.set_renderer(static_cast<v1::Renderer>(settings.renderer));
  if (settings.direction_guard) m.set_direction_guard(*settings.direction_guard);
  return m;
}

AppliedSettings to_settings(const v1::UpdateSettingsResponse& m) {
  AppliedSettings s;
  s.applied = {to_vector(m.stiffness()),
               to_vector(m.damping()),
               to_vector(m.force_limit()),
               to_vector(m.slew_limit()),
               static_cast<Renderer>(m.renderer()),
               m.direction_guard()};
  for (const auto& clamp : m.clamped()) {
    s.clamped.push_back({clamp.field(), clamp.asked(), clamp.applied(), clamp.why()});
  }
  return s;
}

}  // namespace haptic::client
