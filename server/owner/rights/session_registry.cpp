#include "server/owner/rights/session_registry.hpp"

#include <algorithm>
#include <string>

#include "server/base/process.hpp"

namespace haptic::server {
namespace {

const char* plural(Request::Kind kind) {
  if (kind == Request::Kind::kAdmitSession) return "sessions";
  return kind == Request::Kind::kAdmitObserver ? "observers" : "watches";
}

}  // namespace

Outcome<SessionId> SessionRegistry::admit(Kind kind, std::size_t device, bool resumes) {
  if (count(kind) >= (resumes ? 2 : 1) * limit_) {
    return limit_reached(
        "TOO_MANY_SESSIONS",
        std::string(plural(kind)) + ": all " + std::to_string(limit_) + " places are taken",
        limit_);
  }
  std::string name = random_secret();
  const SessionId id = name;
  entries_[std::move(name)] = {kind, device};
  return id;
}

void SessionRegistry::remove(const SessionId& id) {
  const auto entry = entries_.find(id.view());
  if (entry != entries_.end()) entries_.erase(entry);
}

std::optional<std::size_t> SessionRegistry::device_of(const SessionId& id) const {
  const auto entry = entries_.find(id.view());
  if (entry == entries_.end()) return std::nullopt;
  return entry->second.device;
}

std::vector<std::pair<SessionId, SessionRegistry::Kind>> SessionRegistry::all() const {
  std::vector<std::pair<SessionId, Kind>> answer;
  for (const auto& [id, entry] : entries_) answer.emplace_back(id, entry.kind);
  return answer;
}

unsigned SessionRegistry::count(Kind kind, std::optional<std::size_t> device) const {
  return static_cast<unsigned>(std::count_if(entries_.begin(), entries_.end(), [&](const auto& e) {
    return e.second.kind == kind && (!device || e.second.device == *device);
  }));
}

}  // namespace haptic::server
