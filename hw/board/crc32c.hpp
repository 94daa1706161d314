#pragma once
/// CRC-32C (Castagnoli), as in iSCSI: polynomial 0x1EDC6F41 reflected, start and final value all
/// ones. Source: RFC 3720, appendix B.4; check value of "123456789": E3069283.

#include <cstdint>
#include <span>

namespace haptic::hw::board {

[[nodiscard]] std::uint32_t crc32c(std::span<const std::uint8_t> bytes) noexcept;

}  // namespace haptic::hw::board
