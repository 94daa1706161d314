#include "server/owner/rights/session_registry.hpp"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <string>

namespace haptic::server {
namespace {

/// 128 bits from the kernel, in hex. So few never fail once the system has started, unlike the
/// processor's own source behind std::random_device, which may run out and then throws.
std::string random_name() {
  std::array<std::uint64_t, 2> bits{};
  if (getrandom(bits.data(), sizeof bits, 0) != sizeof bits) std::abort();
  return fmt::format("{:016x}{:016x}", bits[0], bits[1]);
}

const char* plural(Request::Kind kind) {
  if (kind == Request::Kind::kAdmitSession) return "sessions";
  return kind == Request::Kind::kAdmitObserver ? "observers" : "watches";
}

}  // namespace

Outcome<SessionId> SessionRegistry::admit(Kind kind, std::size_t device, bool resumes) {
  if (count(kind) >= (resumes ? 2 : 1) * limit_) {
    const std::string limit = std::to_string(limit_);
    return Refusal{Refusal::Code::kExhausted,
                   "TOO_MANY_SESSIONS",
                   std::string(plural(kind)) + ": all " + limit + " places are taken",
                   {},
                   {{{"limit", limit}}}};
  }
  std::string name = random_name();
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
