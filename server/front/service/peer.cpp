#include "server/front/service/peer.hpp"

#include <algorithm>

namespace haptic::server {

bool may_have_keys(const Peer& peer, const FrontConfig& config) noexcept {
  return peer.encrypted || peer.this_host || config.insecure_lab;
}

Rights rights_of(const Peer& peer, const FrontConfig& config) {
  if (peer.token) return *peer.token;
  if (peer.names.empty()) {
    return {peer.encrypted ? Priority::kPrimary : Priority::kOperator,
            "over TLS without a client certificate",
            {}};
  }
  Rights rights{Priority::kOperator, "with this client's certificate",
                "certificate of '" + peer.names.front() + "'"};
  if (!config.tls) return rights;
  // Not listed is primary; listed more than once, by several names, is the highest of them.
  std::optional<Priority> highest;
  for (const TlsClient& client : config.tls->clients) {
    if (std::find(peer.names.begin(), peer.names.end(), client.name) == peer.names.end()) continue;
    highest = std::max(highest.value_or(Priority::kTest), client.highest);
  }
  rights.highest = highest.value_or(Priority::kPrimary);
  return rights;
}

}  // namespace haptic::server
