#pragma once
/// The protection of an address in words, for people.

#include <string>
#include <vector>

#include "server/crossing/front_config.hpp"

namespace haptic::server {

[[nodiscard]] constexpr bool encrypts(Protection protection) noexcept {
  return protection == Protection::kTls || protection == Protection::kMutualTls;
}

/// "TLS", ...: for people.
[[nodiscard]] const char* word(Protection protection) noexcept;
/// The weakness of `address`, a sentence; empty: none.
[[nodiscard]] std::string weakness(const std::string& address, Protection protection);
/// The same of all addresses of a front.
[[nodiscard]] std::vector<std::string> weaknesses(const FrontConfig& config);

}  // namespace haptic::server
