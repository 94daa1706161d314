#include "server/base/process.hpp"

#include <sys/random.h>
#include <unistd.h>

#include <array>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <fstream>

namespace haptic::server {

std::uint64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");  // proc(5): pages, the second number
  std::uint64_t all = 0, resident = 0;
  file >> all >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

std::string random_secret() {
  std::array<std::uint64_t, 2> bits{};
  if (getrandom(bits.data(), sizeof bits, 0) != sizeof bits) std::abort();
  char text[33];
  std::snprintf(text, sizeof text, "%016" PRIx64 "%016" PRIx64, bits[0], bits[1]);
  return text;
}

}  // namespace haptic::server
