#include "server/session/lease.hpp"

#include <algorithm>

namespace haptic::server {

void LeaseBook::take(const LeaseRequest& request) noexcept {
  held_ = true;
  detached_ = false;
  session_id_ = request.session_id;
  client_name_ = request.client_name;
  priority_ = request.priority;
  resumable_ = request.resumable;
}

void LeaseBook::grant(const LeaseRequest& request, core::TimePoint now) {
  take(request);
  opened_ = now;
  ++tenure_;
}

void LeaseBook::end() noexcept {
  held_ = detached_ = resumable_ = false;
  session_id_ = {};
  client_name_ = {};
}

std::uint32_t LeaseBook::resume(const LeaseRequest& request, core::TimePoint now,
                                core::TimePoint last_accepted) {
  take(request);
  if (last_accepted > opened_) opened_ = now;
  ++resumes_;
  return epoch();
}

bool LeaseBook::yields_to(Priority priority) const noexcept {
  return !held_ || priority > priority_ || (detached_ && priority == priority_);
}

bool LeaseBook::expired(core::TimePoint now, core::TimePoint last_accepted) const noexcept {
  return held_ && now - std::max(opened_, last_accepted) >= timeout_;
}

}  // namespace haptic::server
