#pragma once
/// The port of an address.

#include <cstdint>
#include <string>

namespace haptic::test {

inline std::uint16_t port_of(const std::string& address) {
  return static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1)));
}

}  // namespace haptic::test
