#pragma once
/// State that the connections of a WebServer share (private to web_server.cpp). One thread.

#include <memory>
#include <string>
#include <vector>

#include <spdlog/spdlog.h>

#include "server/front/service/unary_methods.hpp"
#include "server/front/web/beast.hpp"
#include "server/front/web/gate.hpp"
#include "server/front/web/json.hpp"
#include "server/front/web/web_content.hpp"
#include "server/front/web/web_server.hpp"

namespace haptic::server {

inline constexpr std::string_view kService = "/haptic.v1.HapticService/";
inline constexpr std::string_view kHealthPath = "/grpc.health.v1.Health/Check";

/// A connection as the server's end sees it.
class WebConnection {
 public:
  virtual ~WebConnection() = default;
  /// Ends it at once.
  virtual void cut() = 0;
};

struct WebShared {
  asio::io_context loop{1};
  ServiceContext& context;
  const WebContent& content;
  Gate gate;
  Json json{};
  std::vector<std::weak_ptr<WebConnection>> open{};
  std::string page_address{};  ///< of a browser; empty: only a UNIX socket

  void add(const std::shared_ptr<WebConnection>& connection) {
    std::erase_if(open, [](const auto& each) { return each.expired(); });
    open.push_back(connection);
  }
  /// For people, with the token that counts now.
  void print_address() const {
    if (page_address.empty()) return;
    if (!content.page.contains("/")) spdlog::warn("{}", kNoPage);
    spdlog::info("page: {}/?token={} (works once)", page_address, gate.one_time());
  }
};

/// A unary call until it is answered, from whichever thread.
struct OpenCall {
  UnaryCall call{};
  const BookedCall booked;
  const asio::executor_work_guard<asio::io_context::executor_type> loop_runs;  ///< till then
};

/// Knowledge of a connection before it says a word.
struct WebPeer {
  Peer peer{};
  FrontConfig::Use use{FrontConfig::Use::kWeb};
  bool unix_socket{false};
};

}  // namespace haptic::server
