#pragma once
/// Messages between a front and the owner on their socket. Samples and stops have another one
/// (sample_socket.hpp).
///
///   front                         owner
///   kHello, its layout   ------>  refuses another layout
///                        <------  kWelcome, with the owner's pages, the socket for samples, the
///                                 configuration, and the files that the owner opened for it
///   kReady               ------>  the front before it is told to leave, and awaited
///                        <------  kGo, with the sockets: serve
///   kServing             ------>
///   kRequest             ------>  answered in OwnersPages::answers
///   kBeat, its counters  ------>  four times a second
///                        <------  kLeave: end the streams, then the process
///
/// kCannotServe comes instead of kReady or kServing, with the reason: a front that is to take
/// another one's place and finds a wrong certificate or token leaves the old one where it is.

#include <cstdint>

#include "server/crossing/crossing.hpp"
#include "server/crossing/front_config.hpp"
#include "server/crossing/sample_socket.hpp"
#include "server/crossing/shared_layout.hpp"

namespace haptic::server {

struct FrontMessage {
  enum class Kind : std::uint8_t { kHello, kReady, kServing, kCannotServe, kRequest, kBeat };
  Kind kind{Kind::kHello};
  std::uint64_t layout{0};   ///< kHello: layout_hash()
  Text<512> text{};          ///< kCannotServe: why; kReady: warnings, a line each
  Request request{};         ///< kRequest
  FrontCounters counters{};  ///< kBeat: what this front has counted so far
};

struct OwnerMessage {
  enum class Kind : std::uint8_t { kWelcome, kGo, kLeave };
  /// Descriptors of kWelcome, in this order; FrontStart's files follow. Those of kGo are its
  /// sockets.
  enum : std::size_t {
    kOwnersPages,
    kSamples,  ///< its end of the socket for samples
    kConfig,   ///< FrontConfig as bytes
    kDescriptors
  };
  Kind kind{Kind::kWelcome};
  std::uint32_t generation{0};    ///< kWelcome: of the front (request_id())
  std::uint64_t config_bytes{0};  ///< kWelcome
};

/// A number that differs, with all likelihood, if two programs were built from different layouts.
[[nodiscard]] consteval std::uint64_t layout_hash() noexcept {
  std::uint64_t hash = kInterface;
  for (const std::uint64_t part :
       {layout<OwnersPages>(), layout<FrontMessage>(), layout<OwnerMessage>(),
        layout<ProxySample>(), layout<PoseSample>(), layout<StopAhead>(), layout<SampleKind>(),
        layout<FrontConfig>()}) {
    hash = hash * 1099511628211ULL ^ part;
  }
  return hash;
}

/// Ids of requests as the owner knows them: the front's own number below, which front above, so
/// that no front gets an answer that was for the one before it.
inline constexpr unsigned kFrontsBits = 48;
inline constexpr std::uint64_t kFrontsId = (std::uint64_t{1} << kFrontsBits) - 1;
/// Ids of the owner's own requests, by the local control socket.
inline constexpr std::uint64_t kLocalIds = std::uint64_t{1} << 63U;

[[nodiscard]] constexpr std::uint64_t request_id(std::uint32_t generation, std::uint64_t id) {
  return (id & kFrontsId) | (std::uint64_t{generation & 0x7FFFU} << kFrontsBits);
}

}  // namespace haptic::server
