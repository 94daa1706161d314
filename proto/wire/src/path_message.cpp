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
  put(response.received_ns, out.subspan(8));
  put(response.sent_ns, out.subspan(16));
  put(response.packets, out.subspan(24));
  put(response.newest, out.subspan(32));
  std::fill(out.begin() + kResponseSize, out.end(), std::uint8_t{0});
}

std::optional<PathChallenge> read_challenge(ConstBytes payload) noexcept {
  if (payload.size() < kShortChallenge) return std::nullopt;
  return PathChallenge{get<std::uint64_t>(payload)};
}

std::optional<PathResponse> read_response(ConstBytes payload) noexcept {
  if (payload.size() < kResponseSize) return std::nullopt;
  return PathResponse{get<std::uint64_t>(payload), get<std::int64_t>(payload.subspan(8)),
                      get<std::int64_t>(payload.subspan(16)),
                      get<std::uint64_t>(payload.subspan(24)),
                      get<std::uint64_t>(payload.subspan(32))};
}

}  // namespace haptic::wire
