#include "server/rpc/waiting_room.hpp"

#include <utility>

namespace haptic::server {

std::shared_ptr<OpenStream> WaitingRoom::enter(const std::shared_ptr<OpenStream>& stream,
                                               core::TimePoint now) {
  std::shared_ptr<OpenStream> longest;
  const std::lock_guard lock(mutex_);
  if (guests_.size() >= places_) {
    longest = guests_.front().stream.lock();
    guests_.pop_front();
  }
  guests_.push_back({stream.get(), stream, now});
  return longest;
}

bool WaitingRoom::leave(const OpenStream& stream) {
  const std::lock_guard lock(mutex_);
  return std::erase_if(guests_, [&](const Guest& guest) { return guest.name == &stream; }) > 0;
}

std::vector<std::shared_ptr<OpenStream>> WaitingRoom::overdue(core::TimePoint now) {
  std::vector<std::shared_ptr<OpenStream>> answer;
  const std::lock_guard lock(mutex_);
  while (!guests_.empty() && now - guests_.front().since >= patience_) {
    if (auto stream = guests_.front().stream.lock()) answer.push_back(std::move(stream));
    guests_.pop_front();
  }
  return answer;
}

std::size_t WaitingRoom::waiting() const {
  const std::lock_guard lock(mutex_);
  return guests_.size();
}

}  // namespace haptic::server
