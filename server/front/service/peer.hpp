#pragma once
/// The other end of a connection, and what it is entitled to.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/crossing/front_config.hpp"
#include "server/front/net/account.hpp"
#include "server/front/session/session.hpp"

namespace haptic::server {

struct Peer {
  bool encrypted{false};  ///< by TLS
  bool this_host{false};  ///< a UNIX socket, or loopback
  /// Names in its certificate: the subject alternative names, else the common name. Empty: it
  /// showed none.
  std::vector<std::string> names{};
  /// Rights of the token that it showed; absent: it showed none.
  std::optional<Rights> token{};
  std::shared_ptr<Account> account{};  ///< of its connection; null: not looked for
};

/// Keys travel only over TLS, a UNIX socket or loopback (proto/README.md#the-udp-path), unless
/// `config` has insecure_lab.
[[nodiscard]] bool may_have_keys(const Peer& peer, const FrontConfig& config) noexcept;

/// The highest priority it may ask for: what its token or its certificate's names are entitled to.
/// Over TLS without either that is kPrimary: it may be any client on the network, and without a
/// name no client takes a device from another (proto/README.md#a-session). In plain text any: then
/// it is a user of this host, or of a lab without protection.
[[nodiscard]] Rights rights_of(const Peer& peer, const FrontConfig& config);

}  // namespace haptic::server
