#include "server/session/lease.hpp"

#include <algorithm>
#include <utility>

namespace haptic::server {

std::uint32_t LeaseBook::grant(std::string session_id, std::string client_name,
                               core::TimePoint now) noexcept {
  held_ = true;
  session_id_ = std::move(session_id);
  client_name_ = std::move(client_name);
  opened_ = now;
  return ++epoch_;
}

void LeaseBook::end() noexcept {
  held_ = false;
  session_id_.clear();
  client_name_.clear();
}

bool LeaseBook::expired(core::TimePoint now, core::TimePoint last_accepted) const noexcept {
  return held_ && now - std::max(opened_, last_accepted) >= timeout_;
}

}  // namespace haptic::server
