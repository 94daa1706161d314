#pragma once
/// The service over HTTP: sessions on WebSockets, unary calls, health, metrics and the page
/// (proto/README.md#the-web). Boost.Beast stays behind this header.

#include <memory>
#include <optional>
#include <span>

#include "server/front/net/tls_files.hpp"
#include "server/front/service/service_context.hpp"
#include "server/front/web/web_content.hpp"

namespace haptic::server {

class WebServer {
 public:
  /// `context` and `content` must outlive the server. `tls`: absent if no address is encrypted.
  /// `token_files`: those of the configuration's tokens. Throws core::TransportError naming the
  /// token's file that is wrong.
  WebServer(ServiceContext& context, const WebContent& content, const std::optional<TlsFiles>& tls,
            std::span<const Descriptor> token_files);
  /// stop() with 1 s.
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// Serves on a thread of its own, and logs the address of the page with a one-time token.
  void start();
  /// A connection by address number `address` of the configuration; takes the descriptor. Says
  /// leave() on its account when it has closed it. Any thread.
  void take(std::size_t address, int descriptor, std::shared_ptr<Account> account);
  /// Closes what is still open after `grace`, and ends the thread. Idempotent.
  void stop(core::Duration grace);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptic::server
