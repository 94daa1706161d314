#pragma once
/// HapticService over gRPC, with reflection and the standard health service. gRPC stays behind this
/// header.

#include <memory>
#include <optional>

#include "server/front/net/tls_files.hpp"
#include "server/front/service/service_context.hpp"

namespace haptic::server {

class RpcServer {
 public:
  /// `context` must outlive the server. `tls`: absent if no address is encrypted.
  RpcServer(ServiceContext& context, std::optional<TlsFiles> tls);
  /// shutdown() with 1 s.
  ~RpcServer();
  RpcServer(const RpcServer&) = delete;
  RpcServer& operator=(const RpcServer&) = delete;

  /// Serves connections at the addresses of gRPC, which are the first. Throws
  /// core::TransportError.
  void start();
  /// A connection by address number `address`; takes the descriptor.
  void take(std::size_t address, int descriptor);
  /// Keeps the standard health service true: overall "", and one entry per device. Any thread.
  void report_health();
  /// Refuses new calls, and waits for those under way for at most `grace`. Idempotent.
  void stop(core::Duration grace);

 private:
  struct Grpc;
  std::unique_ptr<Grpc> grpc_;
};

}  // namespace haptic::server
