#pragma once
/// One connection of the door (private to server/front/net).

#include <memory>

#include "server/front/net/connections.hpp"
#include "server/front/net/peer_name.hpp"

namespace haptic::server {

struct Connections::Connection {
  Descriptor socket{};  ///< a copy: gRPC has its own
  PeerName peer{};
  std::shared_ptr<Account> account{std::make_shared<Account>()};
  Debt debt{};
  Suspicion suspicion{};
  Unread unread{};
  bool over{false};
};

}  // namespace haptic::server
