#pragma once
/// The outside of a datagram (proto/README.md#datagrams): 16 bytes of header in the clear, which
/// the tag covers, then the ciphertext of the payload, then 16 bytes of tag.
///
///   0  2 magic 0x68 0x70 | 2  1 version 1 | 3  1 type | 4  4 path id | 8  8 packet number
///
/// Numbers are big-endian. The path id names a set of keys; it is random, and no secret. Packet
/// numbers begin with 1 under every set of keys and never repeat.

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

namespace haptic::wire {

enum class DatagramType : std::uint8_t {
  kProxy = 1,          ///< up: a serialised haptic.v1.ProxySample
  kState = 2,          ///< down: a serialised haptic.v1.DeviceState
  kPathChallenge = 3,  ///< both ways: path_message.hpp
  kPathResponse = 4,
  kClose = 5,  ///< both ways, no payload: the sender leaves the path
};

using Bytes = std::span<std::uint8_t>;
using ConstBytes = std::span<const std::uint8_t>;

inline constexpr std::array<std::uint8_t, 2> kMagicBytes{0x68, 0x70};  // "hp"
inline constexpr std::uint8_t kProtocolVersion = 1;
inline constexpr std::size_t kHeaderSize = 16;
inline constexpr std::size_t kTagSize = 16;
/// Fits every path of the Internet with IPv6's least MTU, tunnels included
/// (proto/README.md#the-udp-path).
inline constexpr std::size_t kLargestDatagram = 1200;
inline constexpr std::size_t kLargestPayload = kLargestDatagram - kHeaderSize - kTagSize;

struct Header {
  DatagramType type{DatagramType::kClose};
  std::uint32_t path_id{0};
  std::uint64_t packet_number{0};
};

/// Why a datagram was dropped. None is ever answered; each has a counter (link_statistics.hpp).
enum class Rejection : std::uint8_t {
  kNone = 0,
  kLength,       ///< below header and tag, or above 1200
  kMagic,        ///< not of this protocol
  kVersion,      ///< of another version
  kType,         ///< unknown, or not for this direction
  kUnknownPath,  ///< no session has these keys
  kDuplicate,    ///< the packet number came before
  kTooOld,       ///< behind the replay window: not known whether it came before
  kTag,          ///< forged, damaged or sealed with other keys
  kPayload,      ///< genuine, but not the message that its type promises
};
inline constexpr std::size_t kRejections = 10;

/// "TAG", "DUPLICATE", ...
[[nodiscard]] const char* name(Rejection rejection) noexcept;

struct HeaderReading {
  Rejection rejection{Rejection::kNone};
  Header header{};  ///< valid if nothing was rejected
};

/// The checks that need no session: length, magic, version, type.
[[nodiscard]] HeaderReading read_header(ConstBytes datagram) noexcept;
void write_header(const Header& header, std::span<std::uint8_t, kHeaderSize> out) noexcept;

/// Big-endian numbers, `out` and `in` at least as long as the number.
template <std::integral Number>
void put(Number value, Bytes out) noexcept {
  for (std::size_t i = sizeof(Number); i-- > 0; value = static_cast<Number>(value >> 8)) {
    out[i] = static_cast<std::uint8_t>(value & 0xFF);
  }
}
template <std::integral Number>
[[nodiscard]] Number get(ConstBytes in) noexcept {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(Number); ++i) value = value << 8U | in[i];
  return static_cast<Number>(value);
}

}  // namespace haptic::wire
