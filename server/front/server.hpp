#pragma once
/// HapticService on its addresses, by every carrier: gRPC, datagrams, WebSockets and HTTP.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/front/service/service_context.hpp"
#include "server/front/web/web_content.hpp"

namespace haptic::server {

class RpcServer;
class WebServer;

class FrontServer {
 public:
  /// `owner` must outlive the server. `content`: what is served over HTTP besides the service.
  FrontServer(ServiceConfig config, OwnerPort& owner, FactsProvider facts, WebContent content = {});
  /// shutdown() with 1 s.
  ~FrontServer();
  FrontServer(const FrontServer&) = delete;
  FrontServer& operator=(const FrontServer&) = delete;

  /// Binds and serves. Throws TransportError naming the address: in use, not to be resolved, or not
  /// allowed without TLS; or the file of TLS or the token that is wrong.
  void start();
  /// All addresses as bound, ports filled in: those of gRPC, those for browsers, the metrics'.
  /// Empty unless running.
  [[nodiscard]] const std::vector<std::string>& bound_addresses() const noexcept { return bound_; }
  [[nodiscard]] std::string web_address() const;
  /// The metrics'; 0 if there are none.
  [[nodiscard]] std::uint16_t metrics_port() const;
  /// Those of gRPC and of browsers, with a word on what protects each, for people.
  [[nodiscard]] const std::vector<std::string>& served() const noexcept { return served_; }
  /// Weaknesses, a sentence each.
  [[nodiscard]] std::vector<std::string> weaknesses() const { return context_->weaknesses(); }
  /// The UDP path's; 0 if there is none.
  [[nodiscard]] std::uint16_t udp_port() const;
  /// Datagrams dropped since the start, by reason ("TAG", ...); empty without a UDP path.
  [[nodiscard]] std::vector<std::pair<std::string, std::uint64_t>> dropped_datagrams() const;
  /// Connections that are open, and how many were cut since the start because of their bounds.
  [[nodiscard]] std::pair<std::size_t, std::uint64_t> connections() const;
  /// Refuses new calls, ends streams (UNAVAILABLE), waits for at most `grace`, then cuts what is
  /// still connected. Idempotent.
  void shutdown(core::Duration grace);

 private:
  void serve();

  const std::shared_ptr<ServiceContext> context_;  ///< the owner may be calling it still
  const WebContent content_;
  std::unique_ptr<RpcServer> rpc_;
  std::unique_ptr<WebServer> web_{};  ///< null: nothing is served over HTTP
  std::vector<std::string> bound_{}, served_{};
};

}  // namespace haptic::server
