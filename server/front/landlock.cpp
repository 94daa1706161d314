// confine_by_landlock(): what seccomp denies to the front, a second time.
#include <linux/landlock.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "haptic/core/error.hpp"
#include "server/base/descriptor.hpp"
#include "server/front/confinement.hpp"

namespace haptic::server {
namespace {

// Not in Debian 12's <linux/landlock.h>, which knows version 2.
constexpr std::uint64_t kTruncate = 1ULL << 14;
constexpr std::uint64_t kIoctlDevice = 1ULL << 15;
constexpr std::uint64_t kBindAndConnect = 3;
constexpr std::uint64_t kNamesAndSignals = 3;
struct Ruleset {
  std::uint64_t handled_access_fs{0};
  std::uint64_t handled_access_net{0};
  std::uint64_t scoped{0};
};

[[noreturn]] void refused(const std::string& call) {
  throw core::TransportError("confinement of the front: " + call + ": " + std::strerror(errno));
}

}  // namespace

std::string confine_by_landlock() {
  const long version =
      syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 1) {
    return "this kernel has no Landlock: seccomp alone keeps the front from files, ports and "
           "signals";
  }
  Ruleset all;
  all.handled_access_fs = (1ULL << 13) - 1;  // version 1: every kind of access to files
  if (version >= 2) all.handled_access_fs |= LANDLOCK_ACCESS_FS_REFER;
  if (version >= 3) all.handled_access_fs |= kTruncate;
  if (version >= 4) all.handled_access_net = kBindAndConnect;
  if (version >= 5) all.handled_access_fs |= kIoctlDevice;
  if (version >= 6) all.scoped = kNamesAndSignals;
  const std::size_t size = version >= 6   ? sizeof all
                           : version >= 4 ? offsetof(Ruleset, scoped)
                                          : offsetof(Ruleset, handled_access_net);
  const Descriptor ruleset(static_cast<int>(syscall(SYS_landlock_create_ruleset, &all, size, 0)));
  if (!ruleset) refused("landlock_create_ruleset");
  if (syscall(SYS_landlock_restrict_self, ruleset.get(), 0) != 0) refused("landlock_restrict_self");
  if (version >= 6) return {};
  return "this kernel's Landlock (version " + std::to_string(version) +
         ", not 6) knows no signals: seccomp alone keeps the front from them";
}

}  // namespace haptic::server
