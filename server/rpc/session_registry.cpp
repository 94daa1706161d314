#include "server/rpc/session_registry.hpp"

#include <algorithm>
#include <cstdio>
#include <random>

namespace haptic::server {
namespace {

std::string random_name() {
  std::random_device entropy;  // the operating system's own source, not a seeded sequence
  std::string name;
  for (int i = 0; i < 4; ++i) {
    char part[9];
    std::snprintf(part, sizeof part, "%08x", entropy());
    name += part;
  }
  return name;
}

}  // namespace

Outcome<std::string> SessionRegistry::admit(Kind kind, DeviceSessions& device, bool resumes) {
  std::string name = random_name();
  const std::lock_guard lock(mutex_);
  if (count(kind) >= limit_ && !resumes) {
    return Refusal{Refusal::Code::kExhausted,
                   "TOO_MANY_SESSIONS",
                   std::string(kind == Kind::kSession ? "sessions" : "watches") + ": all " +
                       std::to_string(limit_) + " are taken",
                   {},
                   {{"limit", std::to_string(limit_)}}};
  }
  entries_[name] = {kind, &device};
  return name;
}

void SessionRegistry::remove(const std::string& id) {
  const std::lock_guard lock(mutex_);
  entries_.erase(id);
}

DeviceSessions* SessionRegistry::find(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  const auto entry = entries_.find(id);
  if (entry == entries_.end() || entry->second.kind != Kind::kSession) return nullptr;
  return entry->second.device;
}

unsigned SessionRegistry::sessions() const {
  const std::lock_guard lock(mutex_);
  return count(Kind::kSession);
}

unsigned SessionRegistry::count(Kind kind) const {
  return static_cast<unsigned>(std::count_if(entries_.begin(), entries_.end(),
                                             [&](const auto& e) { return e.second.kind == kind; }));
}

}  // namespace haptic::server
