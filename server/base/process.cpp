#include "server/base/process.hpp"

#include <fcntl.h>
#include <sys/random.h>
#include <unistd.h>

#include <array>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>

#include "server/base/descriptor.hpp"

namespace haptic::server {

std::uint64_t resident_bytes() {
  static const Descriptor file(open("/proc/self/statm", O_RDONLY | O_CLOEXEC));
  std::array<char, 64> text{};
  if (pread(file.get(), text.data(), text.size() - 1, 0) <= 0) return 0;
  std::uint64_t pages = 0;  // proc(5): the second number
  static_cast<void>(std::sscanf(text.data(), "%*u %" SCNu64, &pages));
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

std::string random_secret() {
  std::array<std::uint64_t, 2> bits{};
  if (getrandom(bits.data(), sizeof bits, 0) != sizeof bits) std::abort();
  char text[33];
  std::snprintf(text, sizeof text, "%016" PRIx64 "%016" PRIx64, bits[0], bits[1]);
  return text;
}

}  // namespace haptic::server
