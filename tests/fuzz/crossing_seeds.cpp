/// Seeds of crossing_target.cpp: every kind of step, and what a search would hardly come upon.

#include <algorithm>

#include "tests/fuzz/crossing_world.hpp"

namespace haptic::test::crossing {
namespace {

using namespace std::chrono_literals;

/// Appends the patch that makes `to` of `from`.
template <typename T>
void make(FuzzBytes& input, const T& from, const T& to) {
  const auto* const a = reinterpret_cast<const std::uint8_t*>(&from);
  const auto* const b = reinterpret_cast<const std::uint8_t*>(&to);
  const std::size_t count = input.size();
  input.push_back(0);
  for (std::size_t at = 0; at < sizeof(T); ++at) {
    if (a[at] == b[at]) continue;
    std::size_t end = at + 1;  // bytes that are equal for long end a place
    for (std::size_t i = end; i < std::min({at + 255, end + 24, sizeof(T)}); ++i) {
      if (a[i] != b[i]) end = i + 1;
    }
    ++input[count];
    input.insert(input.end(), {static_cast<std::uint8_t>(at >> 8U), static_cast<std::uint8_t>(at),
                               static_cast<std::uint8_t>(end - at)});
    input.insert(input.end(), b + at, b + end);
    at = end;
  }
}

/// Two contacts with all that a contact can have.
ProxySample contacts() {
  ProxySample sample = kHonest;
  sample.mode = core::ProxyMode::kPlanes;
  sample.plane_count = 2;
  for (std::uint32_t p = 0; p < 2; ++p) {
    PlaneSample& plane = sample.planes[p];
    plane.normal = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
    plane.offset = plane.compliance = plane.velocity = plane.uncertainty = 1.0;
    plane.mass = plane.damping = plane.ground_stiffness = plane.load = 1.0;
    plane.id = p + 1;
    plane.tells_uncertainty = plane.object = plane.curvature_count = 1;
    plane.object_direction = {1.0};
  }
  return sample;
}

/// All that may be asked for with a lease, and of the settings.
FrontMessage wishes(bool beyond) {
  FrontMessage message{.kind = FrontMessage::Kind::kRequest};
  for (auto* limit : {&message.request.lease.fresh_end, &message.request.lease.hold_end,
                      &message.request.lease.fade_end}) {
    *limit = beyond ? core::Duration(-1ms) : core::Duration(40ms);
  }
  SettingsRequest& settings = message.request.settings;
  for (Values* values :
       {&settings.stiffness, &settings.damping, &settings.force_limit, &settings.slew_limit}) {
    *values = {beyond ? 1e6 : 0.5};
  }
  settings.renderer = core::RendererKind::kStandard;
  settings.direction_guard = Flag(beyond);
  return message;
}

}  // namespace

std::vector<FuzzBytes> seeds() {
  using Kind = Request::Kind;
  const auto ask = [](FuzzBytes& input, Kind kind, std::uint8_t whose = 0) {
    input.insert(input.end(), {kRequest, static_cast<std::uint8_t>(kind), whose, 0, 0});
  };
  const FuzzBytes turn{kTurn, 0, 39, 16}, tick{kTick, 0, 2, 1};
  const auto append = [](FuzzBytes& input, const FuzzBytes& more) {
    input.insert(input.end(), more.begin(), more.end());
  };
  FuzzBytes controls, tracks, lies;
  for (FuzzBytes* input : {&controls, &tracks, &lies}) {
    ask(*input, Kind::kAdmitSession);
    append(*input, turn);
  }
  ask(controls, Kind::kOpen);
  append(controls, turn);
  append(controls, tick);
  for (int i = 0; i < 3; ++i) {
    append(controls, {kSample, 0});
    append(controls, turn);
  }
  FuzzBytes asks_all = controls, comes_back = controls, touches = controls, wants = controls;
  for (int i = 0; i < 2; ++i) {
    touches.push_back(kSample);
    make(touches, kHonest, contacts());
    append(touches, turn);
  }
  for (const bool beyond : {false, true}) {
    for (const Kind kind : {Kind::kSettings, Kind::kOpen, Kind::kTrack}) {
      ask(wants, kind);
      wants.pop_back();
      make(wants, FrontMessage{.kind = FrontMessage::Kind::kRequest}, wishes(beyond));
      append(wants, turn);
    }
  }
  for (const Kind kind : {Kind::kEngage, Kind::kSettings, Kind::kStop, Kind::kClear, Kind::kRelease,
                          Kind::kCancel, Kind::kLose, Kind::kClose}) {
    ask(asks_all, kind);
    append(asks_all, turn);
    append(asks_all, {kTick, 0, 2, 5});
  }
  ask(comes_back, Kind::kLose);
  for (int i = 0; i < 3; ++i) {
    ask(comes_back, i == 1 ? Kind::kAdmitObserver : Kind::kAdmitSession);
    append(comes_back, turn);
  }
  append(comes_back, {kRequest, static_cast<std::uint8_t>(Kind::kOpen), 1, 1, 0});
  append(comes_back, turn);
  ask(tracks, Kind::kTrack);
  append(tracks, turn);
  append(tracks, {kPose, 0, 0});
  append(tracks, turn);
  // A stop ahead of its request, of a device that is none too, and messages of other sizes.
  append(lies, {kSample, 0, kStop, 0, kStop, 77, kTurn, 0, 0, 0});
  append(lies, {kJunk, 0, 0, 5, 1, 2, 3, 4, 5, kJunk, 1, 0, 9, 1, 0, 0, 0, 0, 0, 0, 0, 7});
  append(lies, turn);
  return {controls, asks_all, comes_back, tracks, lies, touches, wants};
}

}  // namespace haptic::test::crossing
