#pragma once
/// Credentials of the addresses (private to server/rpc).

#include <grpcpp/security/server_credentials.h>

#include <memory>
#include <optional>

#include "server/crossing/tls_config.hpp"
#include "server/net/listen_address.hpp"

namespace haptic::server {

class Credentials {
 public:
  /// Reads the files. Throws TransportError.
  Credentials(const std::optional<TlsConfig>& tls, bool insecure_lab);

  /// The best that an address can have.
  [[nodiscard]] Protection best() const noexcept { return best_; }
  [[nodiscard]] std::shared_ptr<grpc::ServerCredentials> of(Protection protection) const;

 private:
  Protection best_{Protection::kThisHost};
  std::shared_ptr<grpc::ServerCredentials> tls_{};
};

}  // namespace haptic::server
