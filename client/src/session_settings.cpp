/// UpdateSettings: what was asked for, what was applied, what was held at a limit.

#include "error_mapping.hpp"
#include "session_impl.hpp"

namespace haptic::client {

AppliedSettings Session::Impl::update(const Settings& settings) {
  v1::UpdateSettingsRequest request;
  request.set_session_id(session_id());
  request.mutable_stiffness()->Add(settings.stiffness.begin(), settings.stiffness.end());
  request.mutable_damping()->Add(settings.damping.begin(), settings.damping.end());
  request.mutable_force_limit()->Add(settings.force_limit.begin(), settings.force_limit.end());
  request.mutable_slew_limit()->Add(settings.slew_limit.begin(), settings.slew_limit.end());
  request.set_renderer(static_cast<v1::Renderer>(settings.renderer));
  if (settings.direction_guard) request.set_direction_guard(*settings.direction_guard);
  grpc::ClientContext context;
  set_deadline(context);
  v1::UpdateSettingsResponse response;
  check(stub_->UpdateSettings(&context, request, &response));
  AppliedSettings answer;
  const auto list = [](const auto& field) {
    return std::vector<double>(field.begin(), field.end());
  };
  answer.applied.stiffness = list(response.stiffness());
  answer.applied.damping = list(response.damping());
  answer.applied.force_limit = list(response.force_limit());
  answer.applied.slew_limit = list(response.slew_limit());
  answer.applied.renderer = static_cast<Renderer>(response.renderer());
  answer.applied.direction_guard = response.direction_guard();
  for (const auto& clamp : response.clamped()) {
    answer.clamped.push_back({clamp.field(), clamp.asked(), clamp.applied(), clamp.why()});
  }
  return answer;
}

}  // namespace haptic::client
