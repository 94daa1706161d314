#include "server/owner/link/front_process.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "haptic/core/error.hpp"
#include "server/crossing/link_messages.hpp"

namespace haptic::server {

Descriptor event_descriptor() {
  Descriptor made(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!made) throw core::TransportError(std::string("eventfd: ") + std::strerror(errno));
  return made;
}

void empty(const Descriptor& event) {
  std::uint64_t count = 0;
  static_cast<void>(read(event.get(), &count, sizeof count) == sizeof count);
}

FrontProcess::FrontProcess(std::uint32_t its_generation, core::TimePoint now)
    : generation(its_generation),
      wakes_owner(event_descriptor()),
      memory("haptic-front", sizeof(FrontsPages), SharedMemory::Access::kReadAndWrite),
      pages(*static_cast<FrontsPages*>(memory.data())),
      since(now),
      beat_at(now),
      stops(kMostDevices, 0) {
  std::tie(link, its_link) = packet_pair();
}

bool FrontProcess::welcome(int owners_pages, const SharedMemory& config,
                           const FrontStart& start) const {
  std::vector<int> descriptors{owners_pages, memory.descriptor(), wakes_owner.get(),
                               config.descriptor()};
  for (const Descriptor& each : start.sockets) descriptors.push_back(each.get());
  for (const Descriptor& each : start.files) descriptors.push_back(each.get());
  OwnerMessage message;
  message.generation = generation;
  message.config_bytes = config.bytes();
  return send(link.get(), message, descriptors);
}

void FrontProcess::hear() const {
  empty(wakes_owner);
}

void FrontProcess::look(core::TimePoint now) {
  const std::uint64_t seen = pages.beats.load(std::memory_order_relaxed);
  if (seen == beats) return;
  beats = seen;
  beat_at = now;
}

}  // namespace haptic::server
