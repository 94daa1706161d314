#include <sys/resource.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <system_error>

#include "haptic/core/error.hpp"
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
  const Descriptor next(dup(0));
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
  const unsigned wanted = 24 + 4 * std::max(1U, std::thread::hardware_concurrency());
  std::mutex mutex;
  std::condition_variable all_there;
  bool go = false;
  std::vector<std::thread> threads;
  std::string failed;
  try {
    for (unsigned i = 0; i < wanted; ++i) {
      threads.emplace_back([&] {
        std::unique_lock lock(mutex);
        all_there.wait(lock, [&] { return go; });
      });
    }
  } catch (const std::system_error& error) {
    failed = error.what();
  }
  {
    const std::lock_guard lock(mutex);
    go = true;
  }
  all_there.notify_all();
  for (std::thread& thread : threads) thread.join();
  if (failed.empty()) return;
  throw core::TransportError("the process may start only " + std::to_string(threads.size()) +
                             " threads more: needs " + std::to_string(wanted) +
                             " (ulimit -u): " + failed);
}

}  // namespace haptic::server
