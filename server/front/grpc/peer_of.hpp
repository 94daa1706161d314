#pragma once
/// The other end of a call of gRPC (private to server/front/grpc).

#include <grpcpp/server_context.h>

#include <string>

#include "server/front/service/peer.hpp"

namespace haptic::server {

[[nodiscard]] Peer peer_of(const grpc::ServerContextBase& call);

/// True if a gRPC peer's name ("ipv4:127.0.0.1:5", "unix:/path") is on this host.
[[nodiscard]] bool is_this_host(const std::string& peer);

}  // namespace haptic::server
