#pragma once
/// HapticService over gRPC, with reflection and the standard health service. gRPC stays behind this
/// header.

#include <memory>
#include <vector>

#include "server/front/net/listen_address.hpp"
#include "server/front/service/service_context.hpp"

namespace haptic::server {

class RpcServer {
 public:
  /// `context` must outlive the server.
  explicit RpcServer(ServiceContext& context);
  /// shutdown() with 1 s.
  ~RpcServer();
  RpcServer(const RpcServer&) = delete;
  RpcServer& operator=(const RpcServer&) = delete;

  /// Serves connections at addresses with these protections. Throws TransportError naming the file
  /// of TLS that is wrong.
  void start(const std::vector<Protection>& protections);
  /// A connection by address number `address`; takes the descriptor.
  void take(std::size_t address, int descriptor);
  /// Refuses new calls, and waits for those under way for at most `grace`. Idempotent.
  void stop(core::Duration grace);

 private:
  struct Grpc;
  std::unique_ptr<Grpc> grpc_;
};

}  // namespace haptic::server
