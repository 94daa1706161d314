#include "server/owner/rights/lease.hpp"

#include <algorithm>

namespace haptic::server {
namespace {

void take(LeaseBook& lease, const LeaseRequest& request) noexcept {
  lease.has_holder = true;
  lease.detached = false;
  lease.session_id = request.session_id;
  lease.client_name = request.client_name;
  lease.priority = request.priority;
  lease.resumable = request.resumable;
}

}  // namespace

void LeaseBook::grant(const LeaseRequest& request, core::TimePoint now) {
  take(*this, request);
  opened = now;
  ++tenure;
}

void LeaseBook::end() noexcept {
  has_holder = detached = resumable = false;
  session_id = {};
  client_name = {};
}

std::uint32_t LeaseBook::resume(const LeaseRequest& request, core::TimePoint now,
                                core::TimePoint last_accepted) {
  take(*this, request);
  if (last_accepted > opened) opened = now;
  ++resumes;
  return epoch();
}

bool LeaseBook::yields_to(Priority wanted) const noexcept {
  return !has_holder || wanted > priority || (detached && wanted == priority);
}

bool LeaseBook::expired(core::TimePoint now, core::TimePoint last_accepted) const noexcept {
  return has_holder && now - std::max(opened, last_accepted) >= timeout;
}

}  // namespace haptic::server
