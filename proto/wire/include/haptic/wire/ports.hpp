#pragma once
/// The ports that hapticd's pages, scenes, packages and programs use, and the address that a server
/// and its clients take if none is given. They lie below the ephemeral range of Linux (32768), so
/// that no outgoing connection takes one before hapticd starts, and IANA assigns them to no
/// service. Python has kDefaultServer in `haptic/_ports.py`; tests/checks/ports.sh compares the
/// two.

#include <cstdint>

namespace haptic::wire {

inline constexpr std::uint16_t kGrpcPort = 29470;     ///< TCP: the service
inline constexpr std::uint16_t kUdpPort = 29471;      ///< UDP: samples and states (optional)
inline constexpr std::uint16_t kMetricsPort = 29472;  ///< TCP: Prometheus' metrics (optional)
inline constexpr std::uint16_t kWebPort = 29473;      ///< TCP: HTTP, WebSockets, page (optional)

/// kGrpcPort on loopback, as "host:port".
inline constexpr const char* kDefaultServer = "127.0.0.1:29470";
/// kWebPort on loopback.
inline constexpr const char* kDefaultWeb = "127.0.0.1:29473";

}  // namespace haptic::wire
