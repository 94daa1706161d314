#include "server/scene/staleness_scene.hpp"

#include <algorithm>

#include "server/base/figures.hpp"
#include "server/scene/field_reader.hpp"

namespace haptic::server {
namespace {

/// Longer silences than this are no jitter of a network; also the longest lease
/// (proto/README.md#a-session).
constexpr core::Duration kLongestSilence{std::chrono::seconds(60)};
/// What 2.5 periods of a client are clamped to at most (proto/README.md#staleness-and-gain).
constexpr core::Duration kWidestFreshEnd{std::chrono::milliseconds(80)};
/// Shortest fade from full force to none (proto/README.md#staleness-and-gain), and the longest: a
/// release, and so the server's own end, waits for it.
constexpr core::Duration kShortestFade{std::chrono::milliseconds(50)};
constexpr core::Duration kLongestFade{std::chrono::milliseconds(1000)};

void check_order(const FieldReader& reader, const core::StalenessLimits& limits) {
  if (limits.fresh_end > limits.hold_end) {
    reader.wrong("fresh_end", milliseconds(limits.fresh_end),
                 "must be at most hold_end, " + milliseconds(limits.hold_end));
  }
  if (limits.fade_end - limits.hold_end < kShortestFade) {
    reader.wrong("fade_end", milliseconds(limits.fade_end),
                 "must be at least hold_end + " + milliseconds(kShortestFade) + ", " +
                     milliseconds(limits.hold_end + kShortestFade));
  } else if (limits.fade_end - limits.hold_end > kLongestFade) {
    reader.wrong("fade_end", milliseconds(limits.fade_end),
                 "must be at most hold_end + " + milliseconds(kLongestFade) + ", " +
                     milliseconds(limits.hold_end + kLongestFade));
  }
}

}  // namespace

StalenessRead read_staleness(google::protobuf::Message& message, const std::string& path,
                             Problems& problems) {
  const FieldReader reader(message, path, problems);
  const DurationRange any{std::chrono::milliseconds(1), kLongestSilence};
  StalenessRead read;
  core::StalenessLimits& limits = read.limits;
  const std::size_t before = problems.count();
  read.fresh_end = reader.duration("fresh_end", any);
  limits.hold_end = reader.duration("hold_end", limits.hold_end, any);
  limits.fade_end = reader.duration("fade_end", limits.fade_end, any);
  limits.fresh_end = read.fresh_end.value_or(std::min(kWidestFreshEnd, limits.hold_end));
  if (problems.count() == before) check_order(reader, limits);
  return read;
}

}  // namespace haptic::server
