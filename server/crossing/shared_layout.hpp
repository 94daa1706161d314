#pragma once
/// Memory that the owner writes and a front reads, byte by byte. Two programs of different builds
/// must agree on it: a front names its layout in its first message, and the owner refuses another
/// one. There is no memory that a front writes.

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "server/crossing/broadcast.hpp"
#include "server/crossing/crossing.hpp"
#include "server/crossing/layout.hpp"
#include "server/crossing/server_facts.hpp"
#include "server/crossing/tick_totals.hpp"

namespace haptic::server {

/// Raised if the meaning of a value changes and its layout does not.
inline constexpr std::uint32_t kInterface = 1;

template <typename T>
struct Held<Stamped<T>> {
  using Type = T;
};
template <typename T>
struct Held<Latest<T>> {
  using Type = T;
};
template <typename T, std::size_t N>
struct Held<Broadcast<T, N>> {
  using Type = T;
};

/// Devices of a scene at most.
inline constexpr std::size_t kMostDevices = 64;

/// An event and its device.
struct Happened {
  std::uint32_t device{0};
  DeviceEvent event{};
};

/// Counters of a front with which the next one goes on (FrontServer::counted).
inline constexpr std::size_t kFrontCounters = 32;
using FrontCounters = std::array<std::uint64_t, kFrontCounters>;

/// From the owner to every front, one after the other: pages that a front can only read.
struct OwnersPages {
  struct Device {
    Latest<SerialisedState> state;
    Latest<DeviceStatus> status;
    Latest<TickTotals> totals;
  };
  /// A futex: rises when something was written that a front should look at now.
  std::atomic<std::uint32_t> rings;
  Broadcast<Answer, 512> answers;
  Broadcast<Happened, 512> events;
  Broadcast<Judged, 2048> judged;
  Latest<ServerFacts> facts;
  Latest<FrontCounters> counted;  ///< by the fronts before
  std::array<Device, kMostDevices> devices;

  /// Number of its bytes that a scene of so many devices needs.
  [[nodiscard]] static std::size_t bytes(std::size_t devices) noexcept {
    return sizeof(OwnersPages) - (kMostDevices - devices) * sizeof(Device);
  }
};
/// A new front is told the last events, and what is answered after its start.
inline constexpr std::uint64_t kRetold = 256;
/// Requests that a front may have open at a time, and beyond them stops. With one more stop per
/// device, ahead of the queue, they are fewer than the answers that are kept, so that none is
/// overwritten before it was read.
inline constexpr std::size_t kMostOpenRequests = 256;
inline constexpr std::size_t kMostOpenStops = 32;

}  // namespace haptic::server
