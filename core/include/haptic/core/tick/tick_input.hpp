#pragma once
/// Everything one tick depends on, besides the newest sample of the proxy.

#include <array>
#include <cstdint>

#include "haptic/core/fault.hpp"
#include "haptic/core/rendering/renderer_kind.hpp"
#include "haptic/core/safety/staleness.hpp"
#include "haptic/core/time.hpp"
#include "haptic/core/types.hpp"

namespace haptic::core {

/// One measurement of the device.
struct DeviceSample {
  std::uint64_t seq{0};
  TimePoint time{};     ///< when it was measured, on the server's steady clock
  VecQ q{};             ///< n_q; m or rad
  VecA tau_measured{};  ///< n_a, N or N m; size 0 if the device measures no force
};

enum class DeviceHealth : std::uint8_t {
  kOk = 0,
  kLost = 1,           ///< unplugged, closed or broken: fault DEVICE_LOST
  kForceOverLimit = 2  ///< the device itself reports too much force: fault FORCE_OVER_LIMIT
};

/// Answer of Device::read: the newest sample, or none (which is normal:
/// core/METHOD.md#the-device-of-the-paper, the board's USB link is half as fast as its loop).
struct DeviceReading {
  bool fresh{false};  ///< `sample` was not delivered before
  bool armed{false};  ///< the device would follow a force now
  DeviceHealth health{DeviceHealth::kOk};
  DeviceSample sample{};
};

/// A tracked palm stands in q as position and rotation vector.
inline constexpr std::size_t kPalmDofs = 6;

/// The newest accepted pose of the tracked palm, if a client says it (role tracker).
struct TrackerSnapshot {
  std::uint64_t seq{0};         ///< 0: none was accepted so far
  TimePoint born{};             ///< what its age is counted from: the local arrival, or earlier
  Duration valid_for{0};        ///< the tracker's own bound on its freshness; 0 = none given
  StalenessLimits staleness{};  ///< of its session; held within the scene's
  std::array<double, kPalmDofs> pose{};  ///< x, y, z [m], rotation vector [rad], in the world
};

/// Requests of people and programs to the device. Requests are counters: a tick acts on a counter
/// that moved, so that none is lost in a newest-wins mailbox and none acts twice.
struct CommandSnapshot {
  std::uint32_t tenure{0};  ///< of the lease; rises with every new controller
  bool lease_held{false};
  std::uint64_t engage_id{0};
  std::uint64_t release_id{0};
  std::uint64_t stop_id{0};  ///< emergency stop
  std::uint64_t clear_id{0};
  FaultSet clear{};  ///< the faults that clear_id names
  /// The newest stop that the clearing client has seen; a later one is not cleared.
  std::uint64_t clear_stop_id{0};
  bool closing{false};  ///< SIGTERM
};

/// Settings that a running session may change, always within the scene (tighten-only).
struct RenderSettings {
  std::uint64_t id{0};
  RendererKind renderer{RendererKind::kSubspaceLinear};
  bool direction_guard{false};
  VecA stiffness{};      ///< diag(K) of Z_q, n_a; N/m or N m/rad
  VecA damping{};        ///< B of Z_q, n_a, diagonal; N s/m or N m s/rad
  VecA force_limit{};    ///< n_a; N or N m
  VecA slew_limit{};     ///< n_a; N/s or N m/s
  VecA engage_window{};  ///< n_a; largest |Z_q (q*_a - q_a)| at which force may be switched on
  StalenessLimits staleness{};
};

/// The loop's report of itself.
struct LoopReport {
  Duration lateness{0};      ///< now minus the deadline of this tick
  std::uint32_t skipped{0};  ///< deadlines passed over since the last tick
};

struct TickInput {
  TimePoint now{};
  Duration period{std::chrono::milliseconds(1)};
  LoopReport loop{};
  DeviceReading device{};
  TrackerSnapshot tracker{};  ///< only if the scene has a tracker
  CommandSnapshot command{};
  RenderSettings settings{};
};

}  // namespace haptic::core
