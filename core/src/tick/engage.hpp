#pragma once
/// May force be switched on now (proto/README.md#a-session)?

#include "haptic/core/model/dof_layout.hpp"
#include "haptic/core/tick/tick_record.hpp"
#include "session_settings.hpp"

namespace haptic::core {

/// Facts by which an Engage is judged.
struct EngageCase {
  TimePoint now{};
  LifecycleState state{LifecycleState::kInit};  ///< before this tick's step
  bool faulted{false};                          ///< a fault is latched
  const Sensed& sensed;
  const ProxyInUse& proxy;
  const Anchor& anchor;
  const Settings& settings;
  const DofLayout& layout;
  Duration sample_period{};  ///< of the device, nominal
  bool was_free{false};      ///< free() held in some tick under this lease
};

/// True if the sample in use leaves the probe free. A held one may only echo the probe so far.
[[nodiscard]] inline bool free(const ProxyInUse& proxy, const Anchor& anchor) noexcept {
  const bool tells = proxy.mode == ProxyMode::kFree || proxy.mode == ProxyMode::kPlanes;
  return tells && !anchor.in_the_way;
}

/// True if it is unknown on which side of an object the probe is: a held proxy does not say it.
[[nodiscard]] inline bool never_free(const ProxyInUse& proxy, bool was_free) noexcept {
  return proxy.mode == ProxyMode::kHeld && !was_free;
}

/// The answer to the request `id`: accepted, or the first reason against it with its figures. A
/// device that is engaged already accepts.
[[nodiscard]] EngageAnswer judge_engage(std::uint64_t id, const EngageCase& at) noexcept;

}  // namespace haptic::core
