#pragma once
/// The state of a device after one tick, flat: what of a TickRecord the front may see.

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>

#include "haptic/core/tick/tick_record.hpp"

namespace haptic::server {

/// Up to N numbers. `count` may be above N if they came off the wire: then they are refused.
template <std::size_t N>
struct Numbers {
  std::uint32_t count{0};
  std::array<double, N> value{};

  Numbers() = default;
  Numbers(const double* from, std::size_t size) : count(static_cast<std::uint32_t>(size)) {
    std::copy_n(from, std::min(size, N), value.begin());
  }
  Numbers(std::initializer_list<double> list) : Numbers(list.begin(), list.size()) {}

  [[nodiscard]] const double* begin() const noexcept { return value.data(); }
  [[nodiscard]] const double* end() const noexcept {
    return begin() + std::min<std::size_t>(count, N);
  }
};
using Values = Numbers<core::kMaxQ>;       ///< one per DoF, or per actuated DoF
using Coordinates = Numbers<core::kMaxX>;  ///< one per virtual coordinate

/// Which way a sample came.
enum class Carrier : std::uint8_t { kNone = 0, kGrpc = 1, kUdp = 2 };

/// Symbols and units as in core::TickRecord.
struct StateRecord {
  std::uint64_t tick{0};
  core::TimePoint now{};
  core::Duration dt{0};        ///< since the previous tick
  core::Duration lateness{0};  ///< of the loop
  std::uint32_t skipped{0};    ///< deadlines passed over since the last tick

  core::LifecycleState state{core::LifecycleState::kInit};
  bool lost{false};  ///< force was given up in this tick
  core::FaultSet faults{};
  core::LimiterSet limiters{};
  double gain{0.0}, damping_gain{0.0};

  bool lease_held{false};
  std::uint32_t tenure{0};          ///< the lease's number for the loop
  std::uint32_t lease_epoch{0};     ///< the lease's number for clients
  Carrier carrier{Carrier::kNone};  ///< of the proxy in use
  core::ProxyMode mode{core::ProxyMode::kNone};
  core::Staleness staleness{core::Staleness::kLost};
  std::uint64_t proxy_seq{0};
  core::Duration proxy_age{0};
  std::uint32_t active_planes{0};

  std::uint64_t sample_seq{0};   ///< of the device; 0: none so far
  core::Duration sample_age{0};  ///< of that sample
  Values q{}, q_a_dot{};
  Values reading{};       ///< what the device said, if it was refused; else empty
  Values tau_measured{};  ///< empty if the device measures none
  Coordinates x_probe{}, x{};
  Values q_star{}, tau_elastic{}, tau_damping{}, tau_a{};
  Values drive{};          ///< what goes to the device instead of tau_a; empty: tau_a does
  Values temperature_c{};  ///< empty if no winding has a model
  Values stiffness{};      ///< of the settings in use, before the gain
  std::array<std::uint32_t, core::kMaxQ> actuator_limiters{};  ///< n_a of them are set

  core::ProjectionStatus projection{core::ProjectionStatus::kNone};
  double residual{0.0}, condition{0.0};
  core::Certificate certificate{};
  core::PassivityRecord passivity{};
  core::TrackerRecord tracker{};
};

}  // namespace haptic::server
