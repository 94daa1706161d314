#include <sys/eventfd.h>
#include <sys/resource.h>

#include <algorithm>
#include <string>
#include <thread>

#include "haptic/core/error.hpp"
#include "server/base/start_limits.hpp"
#include "server/front/net/connections.hpp"

namespace haptic::server {
namespace {

/// Each is two descriptors, gRPC's and the door's.
constexpr unsigned kOfConnection = 2;
constexpr unsigned kFewest = 8;
constexpr rlim_t kWanted = 1024;

}  // namespace

ConnectionLimits within_descriptors(ConnectionLimits limits) {
  rlimit allowed{};
  getrlimit(RLIMIT_NOFILE, &allowed);
  if (allowed.rlim_cur < kWanted && allowed.rlim_cur < allowed.rlim_max) {
    allowed.rlim_cur = std::min(kWanted, allowed.rlim_max);
    setrlimit(RLIMIT_NOFILE, &allowed);
    getrlimit(RLIMIT_NOFILE, &allowed);
  }
  // The lowest free number is how many are in use, roughly.
  const Descriptor next(eventfd(0, EFD_CLOEXEC));
  const auto used = static_cast<rlim_t>(std::max(next.get(), 3));
  const rlim_t kept = used + kReservedDescriptors;
  const rlim_t room = allowed.rlim_cur > kept ? (allowed.rlim_cur - kept) / kOfConnection : 0;
  if (!next || room < kFewest) {
    throw core::TransportError(
        "the process may open " + std::to_string(allowed.rlim_cur) + " files and sockets: needs " +
        std::to_string(kept + kFewest * kOfConnection) + " or more (ulimit -n)");
  }
  limits.all = static_cast<unsigned>(std::min<rlim_t>(limits.all, room));
  limits.per_peer = std::min(limits.per_peer, std::max(limits.all / 2, kFewest));
  return limits;
}

void require_threads() {
  const std::string lack =
      lack_of_threads(24 + 4 * std::max(1U, std::thread::hardware_concurrency()));
  if (!lack.empty()) throw core::TransportError("the process " + lack);
}

}  // namespace haptic::server
