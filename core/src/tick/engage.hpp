#pragma once
/// May force be switched on now (proto/README.md#a-session)?

#include "haptic/core/model/dof_layout.hpp"
#include "haptic/core/tick/tick_record.hpp"
#include "session_settings.hpp"

namespace haptic::core {

/// What an Engage is judged by.
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
};

/// The answer to the request `id`: accepted, or the first reason against it with its figures. A
/// device that is engaged already accepts.
[[nodiscard]] EngageAnswer judge_engage(std::uint64_t id, const EngageCase& at) noexcept;

}  // namespace haptic::core
