#include "server/base/process.hpp"

#include <fcntl.h>
#include <link.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "server/base/descriptor.hpp"

namespace haptic::server {

namespace {

/// Resident and shared, bytes.
std::pair<std::uint64_t, std::uint64_t> resident() {
  static const Descriptor file(open("/proc/self/statm", O_RDONLY | O_CLOEXEC));
  std::array<char, 64> text{};
  if (pread(file.get(), text.data(), text.size() - 1, 0) <= 0) return {};
  std::uint64_t pages = 0, shared = 0;  // proc(5): the second number and the third
  static_cast<void>(std::sscanf(text.data(), "%*u %" SCNu64 " %" SCNu64, &pages, &shared));
  const auto page = static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  return {pages * page, shared * page};
}

}  // namespace

std::uint64_t resident_bytes() {
  return resident().first;
}

std::uint64_t own_bytes() {
  const auto [all, shared] = resident();
  return all - std::min(all, shared);
}

void forget_the_start() {
  dl_iterate_phdr(
      [](dl_phdr_info* file, std::size_t /*size*/, void* /*none*/) {
        const auto page = static_cast<ElfW(Addr)>(sysconf(_SC_PAGESIZE));
        for (int i = 0; i < file->dlpi_phnum; ++i) {
          const ElfW(Phdr)& part = file->dlpi_phdr[i];
          if (part.p_type != PT_LOAD || (part.p_flags & PF_W) != 0) continue;
          const ElfW(Addr) begin = (file->dlpi_addr + part.p_vaddr) & ~(page - 1);
          const ElfW(Addr) end = file->dlpi_addr + part.p_vaddr + part.p_memsz;
          madvise(reinterpret_cast<void*>(begin), end - begin, MADV_DONTNEED);
        }
        return 0;
      },
      nullptr);
}

std::string random_secret() {
  std::array<std::uint64_t, 2> bits{};
  if (getrandom(bits.data(), sizeof bits, 0) != sizeof bits) std::abort();
  char text[33];
  std::snprintf(text, sizeof text, "%016" PRIx64 "%016" PRIx64, bits[0], bits[1]);
  return text;
}

}  // namespace haptic::server
