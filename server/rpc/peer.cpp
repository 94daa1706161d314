#include "server/rpc/peer.hpp"

#include <grpc/grpc_security_constants.h>
#include <grpcpp/security/auth_context.h>

#include <algorithm>

namespace haptic::server {

bool is_this_host(const std::string& peer) {
  for (const char* local : {"unix:", "ipv4:127.", "ipv6:[::1]:", "ipv6:%5B::1%5D:"}) {
    if (peer.starts_with(local)) return true;
  }
  return false;
}

Peer peer_of(const grpc::ServerContextBase& call) {
  Peer peer;
  peer.this_host = is_this_host(call.peer());
  const auto auth = call.auth_context();
  if (!auth) return peer;
  for (const grpc::string_ref& type :
       auth->FindPropertyValues(GRPC_TRANSPORT_SECURITY_TYPE_PROPERTY_NAME)) {
    peer.encrypted = peer.encrypted || type == GRPC_SSL_TRANSPORT_SECURITY_TYPE;
  }
  if (!peer.encrypted || !auth->IsPeerAuthenticated()) return peer;
  for (const grpc::string_ref& name : auth->GetPeerIdentity()) {
    peer.names.emplace_back(name.data(), name.size());
  }
  return peer;
}

bool may_have_keys(const Peer& peer, const RpcConfig& config) noexcept {
  return peer.encrypted || peer.this_host || config.insecure_lab;
}

Rights rights_of(const Peer& peer, const RpcConfig& config) {
  if (peer.names.empty()) {
    return {peer.encrypted ? Priority::kPrimary : Priority::kOperator,
            "over TLS without a client certificate",
            {}};
  }
  Rights rights{Priority::kOperator, "with this client's certificate", peer.names.front()};
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
