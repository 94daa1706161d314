#include "haptic/wire/path_message.hpp"

#include <algorithm>

namespace haptic::wire {
namespace {

constexpr std::size_t kTokenSize = 8;

}  // namespace

void write(const PathChallenge& challenge, Bytes out) noexcept {
  put(challenge.token, out);
  std::fill(out.begin() + kTokenSize, out.end(), std::uint8_t{0});
}

void write(const PathResponse& response, Bytes out) noexcept {
  put(response.token, out);
  put(static_cast<std::uint64_t>(response.received_ns), out.subspan(8));
  put(static_cast<std::uint64_t>(response.sent_ns), out.subspan(16));
  put(response.packets, out.subspan(24));
  put(response.newest, out.subspan(32));
  std::fill(out.begin() + kResponseSize, out.end(), std::uint8_t{0});
}

std::optional<PathChallenge> read_challenge(ConstBytes payload) noexcept {
  if (payload.size() < kShortChallenge) return std::nullopt;
  return PathChallenge{get_u64(payload)};
}

std::optional<PathResponse> read_response(ConstBytes payload) noexcept {
  if (payload.size() < kResponseSize) return std::nullopt;
  return PathResponse{get_u64(payload), static_cast<std::int64_t>(get_u64(payload.subspan(8))),
                      static_cast<std::int64_t>(get_u64(payload.subspan(16))),
                      get_u64(payload.subspan(24)), get_u64(payload.subspan(32))};
}

}  // namespace haptic::wire
