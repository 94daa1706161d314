#include "server/front/session/messages.hpp"

#include <algorithm>

#include "server/base/figures.hpp"
#include "server/front/session/plane_fields.hpp"

namespace haptic::server {
namespace {

using Doubles = google::protobuf::RepeatedField<double>;

template <typename To>
To numbers(const Doubles& from) {
  return {from.data(), static_cast<std::size_t>(from.size())};
}

/// Answers what was applied, and reports what was held at the scene's.
void report(const char* name, const Values& asked, const Values& applied, Doubles* to,
            v1::UpdateSettingsResponse& message) {
  to->Clear();
  to->Add(applied.begin(), applied.end());
  for (std::size_t i = 0; i < asked.count; ++i) {
    if (asked.value[i] <= applied.value[i]) continue;
    auto* entry = message.add_clamped();
    entry->set_field(std::string(name) + "[" + std::to_string(i) + "]");
    entry->set_asked(asked.value[i]);
    entry->set_applied(applied.value[i]);
    entry->set_why("the scene allows at most this");
  }
}

core::Duration duration(const google::protobuf::Duration& message) {
  // Far beyond any limit of the server, far below what 64 bits of nanoseconds hold.
  const std::int64_t seconds = std::clamp<std::int64_t>(message.seconds(), -86400, 86400);
  return std::chrono::seconds(seconds) + std::chrono::nanoseconds(message.nanos());
}

}  // namespace

void set(google::protobuf::Duration& message, core::Duration d) {
  const auto whole = std::chrono::duration_cast<std::chrono::seconds>(d);
  message.set_seconds(whole.count());
  message.set_nanos(static_cast<std::int32_t>((d - whole).count()));
}

v1::Event to_proto(const DeviceEvent& event) {
  v1::Event message;
  message.set_kind(static_cast<v1::Event::Kind>(event.kind));
  message.set_server_time_ns(event.time.time_since_epoch().count());
  message.set_reason(event.reason.str());
  message.set_message(event.message.str());
  message.set_state(static_cast<v1::DeviceStateName>(event.state));
  message.set_lease_epoch(event.lease_epoch);
  return message;
}

v1::UpdateSettingsResponse to_proto(const SettingsRequest& asked, const Settings& applied) {
  v1::UpdateSettingsResponse message;
  report("stiffness", asked.stiffness, applied.stiffness, message.mutable_stiffness(), message);
  report("damping", asked.damping, applied.damping, message.mutable_damping(), message);
  report("force_limit", asked.force_limit, applied.force_limit, message.mutable_force_limit(),
         message);
  report("slew_limit", asked.slew_limit, applied.slew_limit, message.mutable_slew_limit(), message);
  message.set_renderer(static_cast<v1::Renderer>(applied.renderer));
  message.set_direction_guard(applied.direction_guard);
  return message;
}

v1::GetServerInfoResponse to_proto(const ServerFacts& facts) {
  v1::GetServerInfoResponse info;
  info.set_version(facts.version.str());
  info.set_protocol("haptic.v1");
  info.set_scene(facts.scene.str());
  v1::RealtimeGrant& realtime = *info.mutable_realtime();
  realtime.set_requested(facts.realtime.requested.str());
  realtime.set_sched_fifo(facts.realtime.sched_fifo);
  realtime.set_priority(facts.realtime.priority);
  realtime.set_memory_locked(facts.realtime.memory_locked);
  realtime.set_timer_slack(facts.realtime.timer_slack);
  realtime.set_cpu(facts.realtime.cpu);
  realtime.set_grade(facts.realtime.grade.str());
  realtime.set_explanation(facts.realtime.explanation.str());
  v1::LoopStatistics& loop = *info.mutable_loop();
  loop.set_ticks(facts.loop.ticks);
  loop.set_skipped(facts.loop.skipped);
  loop.set_lateness_p50_us(microseconds(facts.loop.lateness.p50));
  loop.set_lateness_p99_us(microseconds(facts.loop.lateness.p99));
  loop.set_lateness_max_us(microseconds(facts.loop.lateness.max));
  loop.set_tick_p50_us(microseconds(facts.loop.tick_time.p50));
  loop.set_tick_p99_us(microseconds(facts.loop.tick_time.p99));
  loop.set_records_dropped(facts.loop.records_dropped);
  loop.set_paced_by_sample(facts.loop.paced_by_sample);
  loop.set_paced_by(facts.loop.paced_by.str());
  set(*info.mutable_uptime(), facts.uptime);
  return info;
}

v1::Device describe(const DeviceFacts& facts, const DeviceStatus& status, core::Duration period) {
  v1::Device message;
  message.ParseFromString(facts.description);
  message.set_loop_rate_hz(1.0 / core::seconds(period));
  message.set_state(static_cast<v1::DeviceStateName>(status.state));
  message.set_faults(status.faults.bits());
  message.set_controller(status.controller.str());
  message.set_renderer(static_cast<v1::Renderer>(status.renderer));
  message.set_observers(status.observers);
  if (message.wants_tracker()) message.set_tracker(status.tracker.str());
  return message;
}

SessionId session_id(const std::string& text) {
  constexpr std::size_t kLongest = 32;
  return text.size() <= kLongest ? SessionId(text) : SessionId();
}

namespace {

void from_proto(const v1::Plane& message, PlaneSample& plane) {
  plane.normal = numbers<Numbers<PlaneSample::kNumbers>>(message.normal());
  plane.object_direction = numbers<Numbers<core::kMaxMotions>>(message.object_direction());
  read_fields(message, plane);
  plane.curvature_count = static_cast<std::uint32_t>(message.curvature_size());
  const std::size_t behind = std::min<std::size_t>(plane.normal.count, PlaneSample::kNumbers);
  const std::size_t fit =
      std::min<std::size_t>(plane.curvature_count, PlaneSample::kNumbers - behind);
  std::copy_n(message.curvature().begin(), fit, plane.normal.value.begin() + behind);
}

}  // namespace

void from_proto(const v1::ProxySample& message, ProxySample& sample) {
  sample.seq = message.seq();
  if (v1::ProxyMode_IsValid(message.mode())) {
    sample.mode = static_cast<core::ProxyMode>(message.mode());
  }
  sample.valid_for = std::chrono::microseconds(message.valid_for_us());
  sample.tick_used = message.device_seq_used();
  sample.position = numbers<Coordinates>(message.position());
  sample.plane_count = static_cast<std::uint32_t>(message.planes_size());
  const int taken = std::min(message.planes_size(), core::kMaxPlanes);
  for (int i = 0; i < taken; ++i) {
    from_proto(message.planes(i), sample.planes[static_cast<std::size_t>(i)]);
  }
}

PoseSample from_proto(const v1::TrackerSample& message) {
  PoseSample pose;
  pose.seq = message.seq();
  pose.valid_for = std::chrono::microseconds(message.valid_for_us());
  pose.position = numbers<Numbers<3>>(message.position());
  pose.orientation = numbers<Numbers<4>>(message.orientation());
  return pose;
}

LeaseRequest from_proto(const v1::OpenSession& open, const std::string& client_name) {
  LeaseRequest request;
  request.client_name = client_name;
  request.nominal_rate_hz = open.nominal_rate_hz();
  if (open.priority() != v1::PRIORITY_UNSPECIFIED) {
    request.priority = static_cast<Priority>(open.priority());
  }
  request.resumable = open.resumable();
  request.resume = session_id(open.resume());
  if (open.has_fresh_end()) request.fresh_end = duration(open.fresh_end());
  if (open.has_hold_end()) request.hold_end = duration(open.hold_end());
  if (open.has_fade_end()) request.fade_end = duration(open.fade_end());
  return request;
}

Outcome<SettingsRequest> from_proto(const v1::UpdateSettingsRequest& message) {
  SettingsRequest request;
  request.stiffness = numbers<Values>(message.stiffness());
  request.damping = numbers<Values>(message.damping());
  request.force_limit = numbers<Values>(message.force_limit());
  request.slew_limit = numbers<Values>(message.slew_limit());
  if (!v1::Renderer_IsValid(message.renderer())) {
    return Refusal{Refusal::Code::kInvalid, "INVALID_ARGUMENT",
                   "renderer = " + std::to_string(message.renderer()) + ": must be 1.." +
                       std::to_string(v1::Renderer_MAX),
                   "renderer"};
  }
  if (message.renderer() != v1::RENDERER_UNSPECIFIED) {
    request.renderer = static_cast<core::RendererKind>(message.renderer());
  }
  if (message.has_direction_guard()) request.direction_guard = message.direction_guard();
  return request;
}

}  // namespace haptic::server
