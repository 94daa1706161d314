#include "server/front/grpc/peer_of.hpp"

#include <grpc/grpc_security_constants.h>
#include <grpcpp/security/auth_context.h>

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

}  // namespace haptic::server
