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

/// Force of the spring at the probe, n_a, N or N m.
VecA pull(const EngageCase& at) noexcept {
  return at.settings.unlimited(at.anchor.stretch(at.layout, at.sensed.q)).cwiseAbs();
}

/// The first DoF whose force is not within `share` of its window; n_a: none.
int beyond(const VecA& force, const EngageCase& at, double share) noexcept {
  int i = 0;
  while (i < at.layout.n_a() && force[i] <= share * at.settings.engage_window[i]) ++i;
  return i;
}

}  // namespace

bool free(const EngageCase& at) noexcept {
  return at.proxy.mode != ProxyMode::kNone && beyond(pull(at), at, kFreeShare) == at.layout.n_a();
}

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
  const bool has_proxy = proxy.mode != ProxyMode::kNone;
  const Duration hold_end = at.settings.staleness.hold_end;
  if (!has_proxy || proxy.age >= hold_end) {
    return refuse(EngageVerdict::kStreamStale, has_proxy ? milliseconds_of(proxy.age) : HUGE_VAL,
                  milliseconds_of(hold_end));
  }
  if (proxy.gapless_samples < kSamples) {
    return refuse(EngageVerdict::kTooFewSamples, static_cast<double>(proxy.gapless_samples),
                  static_cast<double>(kSamples));
  }
  const Duration gapless = at.now - proxy.gapless_since;
  if (gapless < kGapless) {
    return refuse(EngageVerdict::kStreamTooYoung, milliseconds_of(gapless),
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
  const VecA jump = pull(at);
  const auto refuse_above = [&](EngageVerdict verdict, double share, int i) {
    return refuse(verdict, jump[i], share * at.settings.engage_window[i], i);
  };
  if (const int i = beyond(jump, at, 1.0); i < at.layout.n_a()) {
    return refuse_above(EngageVerdict::kOutsideWindow, 1.0, i);
  }
  // A client that joins inside an object may pull the probe through it.
  if (const int i = beyond(jump, at, kFreeShare); !at.was_free && i < at.layout.n_a()) {
    return refuse_above(EngageVerdict::kNeverFree, kFreeShare, i);
  }
  return accepted;
}

}  // namespace haptic::core
