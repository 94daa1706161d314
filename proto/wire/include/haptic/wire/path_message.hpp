#pragma once
/// Payloads of PATH_CHALLENGE and PATH_RESPONSE (proto/README.md): fixed layouts, big-endian, zeros
/// behind them up to the size that is to be proven.

#include <optional>

#include "haptic/wire/datagram.hpp"
#include "haptic/wire/time.hpp"

namespace haptic::wire {

///   0  8 token
struct PathChallenge {
  std::uint64_t token{0};
};

///   0  8 token | 8  8 received_ns | 16  8 sent_ns | 24  8 packets | 32  8 newest packet number
/// It is as long as the challenge, so that a forged sender address draws no more bytes than were
/// sent.
struct PathResponse {
  std::uint64_t token{0};
  std::int64_t received_ns{0};  ///< responder's steady clock when the challenge came
  std::int64_t sent_ns{0};      ///< and when this left
  std::uint64_t packets{0};     ///< genuine datagrams of the challenger, under the keys in use
  std::uint64_t newest{0};      ///< the highest packet number among them
};

inline constexpr std::size_t kResponseSize = 40;
/// A challenge is never shorter than its response.
inline constexpr std::size_t kShortChallenge = kResponseSize;
inline constexpr std::size_t kPaddedChallenge = kLargestPayload;

/// Fill all of `out` (at least kResponseSize).
void write(const PathChallenge& challenge, Bytes out) noexcept;
void write(const PathResponse& response, Bytes out) noexcept;
/// None if the payload is shorter than kResponseSize. Bytes after it are ignored: later versions
/// may use them.
[[nodiscard]] std::optional<PathChallenge> read_challenge(ConstBytes payload) noexcept;
[[nodiscard]] std::optional<PathResponse> read_response(ConstBytes payload) noexcept;

}  // namespace haptic::wire
