#include "engage.hpp"

#include <cmath>

#include "sensing.hpp"

namespace haptic::core {

namespace {

constexpr Duration kGapless{std::chrono::milliseconds(200)};
constexpr std::uint64_t kSamples = 10;

double milliseconds_of(Duration d) noexcept {
  return seconds(d) * 1e3;
}

}  // namespace

EngageAnswer judge_engage(std::uint64_t id, const EngageCase& at) noexcept {
  const EngageAnswer accepted{.id = id, .verdict = EngageVerdict::kAccepted};
  const auto refuse = [id](EngageVerdict verdict, double value, double limit, int index = 0) {
    return EngageAnswer{id, verdict, index, value, limit};
  };
  if (at.state == LifecycleState::kEngaging || at.state == LifecycleState::kEngaged)
    return accepted;
  if (at.state != LifecycleState::kArmed || at.faulted) {
    return refuse(EngageVerdict::kNotArmed, static_cast<double>(at.state),
                  static_cast<double>(LifecycleState::kArmed));
  }
  const ProxyInUse& proxy = at.proxy;
  const StreamRate& rate = proxy.too_fast;
  const auto refuse_stream = [&](EngageVerdict verdict, double value, double limit) {
    if (rate.comes_hz == 0.0) return refuse(verdict, value, limit);
    return refuse(EngageVerdict::kTooFast, rate.comes_hz, rate.announced_hz);
  };
  const bool has_proxy = proxy.mode != ProxyMode::kNone;
  const Duration hold_end = at.settings.staleness.hold_end;
  if (!has_proxy || proxy.age >= hold_end) {
    return refuse_stream(EngageVerdict::kStreamStale,
                         has_proxy ? milliseconds_of(proxy.age) : HUGE_VAL,
                         milliseconds_of(hold_end));
  }
  if (proxy.gapless_samples < kSamples) {
    return refuse_stream(EngageVerdict::kTooFewSamples, static_cast<double>(proxy.gapless_samples),
                         static_cast<double>(kSamples));
  }
  const Duration gapless = at.now - proxy.gapless_since;
  if (gapless < kGapless) {
    return refuse_stream(EngageVerdict::kStreamTooYoung, milliseconds_of(gapless),
                         milliseconds_of(kGapless));
  }
  if (!at.sensed.recent) {
    return refuse(EngageVerdict::kDeviceStale, milliseconds_of(at.sensed.age),
                  milliseconds_of(kRecentPeriods * at.sample_period));
  }
  const TrackerRecord& tracker = at.sensed.tracker;
  if (tracker.on && (tracker.seq == 0 || tracker.age >= tracker.hold_end)) {
    return refuse(EngageVerdict::kTrackerStale,
                  tracker.seq != 0 ? milliseconds_of(tracker.age) : HUGE_VAL,
                  milliseconds_of(tracker.hold_end));
  }
  if (never_free(proxy, at.was_free)) return refuse(EngageVerdict::kNeverFree, 0.0, 0.0);
  const VecA jump = at.settings.unlimited(at.anchor.stretch(at.layout, at.sensed.q));
  for (int i = 0; i < at.layout.n_a(); ++i) {
    const double limit = at.settings.engage_window[i];
    if (!(std::abs(jump[i]) <= limit)) {
      return refuse(EngageVerdict::kOutsideWindow, std::abs(jump[i]), limit, i);
    }
  }
  return accepted;
}

}  // namespace haptic::core
