#pragma once
/// The service over HTTP: sessions on WebSockets, unary calls, health, metrics and the page
/// (proto/README.md#the-web). Boost.Beast stays behind this header.

#include <memory>
#include <string>
#include <vector>

#include "server/front/net/listen_address.hpp"
#include "server/front/service/service_context.hpp"
#include "server/front/web/web_content.hpp"

namespace haptic::server {

class WebServer {
 public:
  /// Part of the server that an address serves.
  enum class Scope : std::uint8_t { kAll, kMetrics };
  struct Address {
    std::string bound{};  ///< "HOST:PORT", "unix:/PATH"
    Protection protection{Protection::kThisHost};
    Scope scope{Scope::kAll};
  };

  /// Both must outlive the server. Throws TransportError naming the token's or TLS's file that is
  /// wrong.
  WebServer(ServiceContext& context, const WebContent& content, std::vector<Address> addresses);
  /// stop() with 1 s.
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// Serves on a thread of its own, and logs the address of the page with a one-time token.
  void start();
  /// A connection by address number `address`; takes the descriptor. Says leave() on its account
  /// when it has closed it. Any thread.
  void take(std::size_t address, int descriptor, std::shared_ptr<Account> account);
  /// Closes what is still open after `grace`, and ends the thread. Idempotent.
  void stop(core::Duration grace);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptic::server
