#pragma once
/// The keys of a path: one key and salt per direction, made by the server, delivered on the gRPC
/// stream (TLS, a UNIX socket or loopback only, proto/README.md#the-udp-path), fresh with every
/// lease epoch and rekey.

#include <array>
#include <cstdint>

namespace haptic::wire {

inline constexpr std::size_t kKeySize = 16;    // AES-128
inline constexpr std::size_t kSaltSize = 4;    // of the nonce
inline constexpr std::size_t kNonceSize = 12;  // of GCM: salt and packet number

struct DirectionKey {
  std::array<std::uint8_t, kKeySize> key{};
  std::array<std::uint8_t, kSaltSize> salt{};
};

struct PathKeys {
  std::uint32_t path_id{0};  ///< never 0
  DirectionKey up{};         ///< client to server
  DirectionKey down{};       ///< server to client
};

/// From the operating system's entropy by way of OpenSSL. Throws std::runtime_error if there is
/// none: a path with guessable keys must not exist.
[[nodiscard]] PathKeys fresh_keys();
/// 64 random bits, for challenges. Throws as fresh_keys().
[[nodiscard]] std::uint64_t random_token();

/// Nonce of a packet: salt, then the packet number in big-endian. Unique as long as packet numbers
/// are, under one key.
[[nodiscard]] std::array<std::uint8_t, kNonceSize> nonce(
    const std::array<std::uint8_t, kSaltSize>& salt, std::uint64_t packet_number) noexcept;

}  // namespace haptic::wire
