#pragma once
/// The other end of a call, and what it is entitled to (private to server/rpc).

#include <grpcpp/server_context.h>

#include <memory>
#include <string>
#include <vector>

#include "server/front/session.hpp"
#include "server/net/account.hpp"
#include "server/rpc/rpc_server.hpp"

namespace haptic::server {

struct Peer {
  bool encrypted{false};  ///< by TLS
  bool this_host{false};  ///< a UNIX socket, or loopback
  /// Of its certificate: the subject alternative names, else the common name. Empty: it showed
  /// none.
  std::vector<std::string> names{};
  std::shared_ptr<Account> account{};  ///< of its connection; null: not looked for
};

[[nodiscard]] Peer peer_of(const grpc::ServerContextBase& call);

/// Whether a gRPC peer's name ("ipv4:127.0.0.1:5", "unix:/path") is on this host.
[[nodiscard]] bool is_this_host(const std::string& peer);

/// Keys travel only over TLS, a UNIX socket or loopback (proto/README.md#the-udp-path), unless
/// `config` has insecure_lab.
[[nodiscard]] bool may_have_keys(const Peer& peer, const RpcConfig& config) noexcept;

/// The highest priority it may ask for: what its certificate's names are entitled to. Over TLS
/// without a certificate that is kPrimary: it may be any client on the network, and without a name
/// no client takes a device from another (proto/README.md#a-session). In plain text any: then it is
/// a user of this host, or of a lab without protection.
[[nodiscard]] Rights rights_of(const Peer& peer, const RpcConfig& config);

}  // namespace haptic::server
