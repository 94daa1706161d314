#pragma once
/// Configuration of a front, which knows no scene, and what the owner opened for it.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "haptic/core/safety/staleness.hpp"
#include "haptic/core/time.hpp"
#include "server/base/descriptor.hpp"
#include "server/crossing/listen_address.hpp"
#include "server/crossing/tls_config.hpp"
#include "server/crossing/web_config.hpp"

namespace haptic::server {

/// Facts of a device that never change while it is open.
struct DeviceFacts {
  std::string name{};
  std::string description{};          ///< v1::Device, serialised (owner/state/device_message.hpp)
  core::StalenessLimits staleness{};  ///< the scene's
  core::Duration lease_timeout{};
  std::uint64_t largest_state{0};  ///< bytes of a v1::DeviceState at most
};

struct FrontConfig {
  enum class Use : std::uint8_t { kGrpc, kWeb, kMetrics };
  /// An address as it is bound.
  struct Address {
    std::string name{};  ///< "127.0.0.1:0", "unix:/run/hapticd/s"
    Use use{Use::kGrpc};
    Protection protection{Protection::kThisHost};
    std::uint32_t sockets{1};  ///< a name may stand for several
  };

  std::string scene{};               ///< its name
  std::string log_level{"info"};     ///< as --log-level
  std::vector<Address> addresses{};  ///< gRPC's, then browsers', then the metrics'
  std::string udp_listen{};          ///< as bound; empty: there is no UDP path
  std::uint32_t max_sessions{32};    ///< session streams; and, apart from them, watches
  core::Duration period{std::chrono::milliseconds(1)};  ///< of the loop
  std::optional<TlsConfig> tls{};                       ///< absent: plain text
  std::optional<WebConfig> web{};                       ///< absent: no browsers
  /// Plain text, and the keys of the UDP path in it, on any address.
  bool insecure_lab{false};
  std::vector<DeviceFacts> devices{};
};

/// The same as bytes, and back. Throws core::TransportError that names the field: it ends too
/// early, has a value that is not allowed, or bytes follow it.
[[nodiscard]] std::string to_bytes(FrontConfig config);
[[nodiscard]] FrontConfig front_config(std::string_view bytes);
/// Bytes of a configuration at most. A device takes some KB, most of them its drawing.
inline constexpr std::size_t kLargestConfig = std::size_t{4} << 20U;

/// Everything that a front starts from.
struct FrontStart {
  FrontConfig config{};
  /// Bound, listening and non-blocking: those of the addresses in their order, then the UDP path's.
  std::vector<Descriptor> sockets{};
  /// Opened for reading: TLS's certificate, key and, if there is one, client_ca; the tokens'; for
  /// browsers the folder of the page, or /dev/null if there is none.
  std::vector<Descriptor> files{};
};
/// How many descriptors belong to `config`.
[[nodiscard]] std::size_t sockets_of(const FrontConfig& config);
[[nodiscard]] std::size_t files_of(const FrontConfig& config);

}  // namespace haptic::server
