#pragma once
/// The kernel's words to this process.

#include <cstdint>
#include <string>

namespace haptic::server {

/// Resident memory of this process, bytes; 0: not known. The first call opens the file for all.
[[nodiscard]] std::uint64_t resident_bytes();
/// Its part that is no file's: programs and libraries come and go as the kernel likes.
[[nodiscard]] std::uint64_t own_bytes();

/// Unmaps the pages of programs and libraries that nothing has changed. Only the start uses many of
/// them. The kernel maps a page again when it is used.
void forget_the_start();

/// 128 bits from the kernel, in hex. So few never fail once the system has started, unlike the
/// processor's own source behind std::random_device, which may run out and then throws.
[[nodiscard]] std::string random_secret();

}  // namespace haptic::server
