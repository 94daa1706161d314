#include "server/owner/link/front_process.hpp"

#include <fcntl.h>

#include <utility>

namespace haptic::server {

FrontProcess::FrontProcess(std::uint32_t its_generation, core::TimePoint now)
    : FrontProcess(its_generation, now, packet_pair()) {}

FrontProcess::FrontProcess(std::uint32_t its_generation, core::TimePoint now,
                           std::pair<Descriptor, Descriptor> log_ends)
    : generation(its_generation),
      its_log(std::move(log_ends.second)),
      log(std::move(log_ends.first)),
      since(now),
      beat_at(now) {
  fcntl(its_log.get(), F_SETFL, 0);  // a program that prints waits
  std::tie(link, its_link) = packet_pair();
  std::tie(samples, its_samples) = packet_pair();
}

FrontProcess::~FrontProcess() {
  close_aside(std::move(link));
  close_aside(std::move(samples));
}

bool FrontProcess::welcome(const SharedMemory& owners_pages, const SharedMemory& config,
                           const std::vector<Descriptor>& files) {
  const Descriptor pages = owners_pages.for_reader(), its_config = config.for_reader();
  std::vector<int> descriptors{pages.get(), its_samples.get(), its_config.get()};
  for (const Descriptor& each : files) descriptors.push_back(each.get());
  OwnerMessage message;
  message.generation = generation;
  message.config_bytes = config.bytes();
  const bool sent = send(link.get(), message, descriptors);
  its_samples = Descriptor();
  return sent;
}

bool FrontProcess::go(const std::vector<Descriptor>& sockets) const {
  std::vector<int> descriptors;
  for (const Descriptor& each : sockets) descriptors.push_back(each.get());
  return send(link.get(), OwnerMessage{OwnerMessage::Kind::kGo}, descriptors);
}

}  // namespace haptic::server
