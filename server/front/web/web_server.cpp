#include "server/front/web/web_server.hpp"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <future>
#include <optional>
#include <thread>
#include <utility>

#include "haptic/core/error.hpp"
#include "server/base/thread_setup.hpp"
#include "server/front/net/peer_name.hpp"
#include "server/front/net/protection.hpp"
#include "server/front/web/http_connection.hpp"
#include "server/front/web/tls_names.hpp"

namespace haptic::server {
namespace {

using Addresses = std::vector<FrontConfig::Address>;
using Use = FrontConfig::Use;

constexpr std::chrono::seconds kHandshakeWithin{5};

bool is_any(const std::string& host) {
  return host == "0.0.0.0" || host == "[::]";
}

/// For browsers, by TCP; null: none.
const FrontConfig::Address* first_address(const Addresses& addresses) {
  for (const FrontConfig::Address& address : addresses) {
    if (address.use == Use::kWeb && unix_path(address.name).empty()) return &address;
  }
  return nullptr;
}

/// Names by which the listeners are reached.
std::vector<std::string> names_of(const WebConfig& config, const Addresses& addresses) {
  std::vector<std::string> names = config.names;
  for (const FrontConfig::Address& address : addresses) {
    if (address.use == Use::kGrpc || !unix_path(address.name).empty()) continue;
    const std::string host = host_of(address.name);
    if (!is_any(host)) names.push_back(host);
    if (!is_any(host) && !is_loopback(host)) continue;
    names.insert(names.end(), {"localhost", "127.0.0.1", "[::1]"});
  }
  return names;
}

std::string cookie_port(const Addresses& addresses) {
  const FrontConfig::Address* const first = first_address(addresses);
  return first != nullptr ? port_of(first->name) : std::string();
}

/// Where the page is found by people; empty: nowhere.
std::string page_address(const WebConfig& config, const Addresses& addresses) {
  const FrontConfig::Address* const first = first_address(addresses);
  if (first == nullptr) return {};
  std::string host = host_of(first->name);
  if (is_any(host)) host = "localhost";
  if (!config.names.empty() && first->protection != Protection::kThisHost) {
    host = config.names.front();
  }
  return (encrypts(first->protection) ? "https://" : "http://") + host + ":" + port_of(first->name);
}

/// A client certificate is asked for if there is an issuer of them, and not required.
std::unique_ptr<asio::ssl::context> tls_context(const TlsFiles& files) {
  auto context = std::make_unique<asio::ssl::context>(asio::ssl::context::tls_server);
  SSL_CTX_set_min_proto_version(context->native_handle(), TLS1_2_VERSION);
  SSL_CTX_set_options(context->native_handle(), SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION);
  context->use_certificate_chain(asio::buffer(files.certificate));
  context->use_private_key(asio::buffer(files.key), asio::ssl::context::pem);
  if (!files.client_ca.empty()) {
    context->add_certificate_authority(asio::buffer(files.client_ca));
    context->set_verify_mode(asio::ssl::verify_peer);
    constexpr unsigned char kName[] = "hapticd";
    SSL_CTX_set_session_id_context(context->native_handle(), kName, sizeof kName - 1);
  }
  return context;
}

}  // namespace

class WebServer::Impl {
 public:
  Impl(ServiceContext& context, const WebContent& content, const std::optional<TlsFiles>& tls,
       std::span<const Descriptor> token_files)
      : addresses_(context.config.addresses),
        tls_(tls ? tls_context(*tls) : nullptr),
        shared_{.context = context,
                .content = content,
                .gate = Gate(config_of(context), token_files,
                             names_of(config_of(context), addresses_), cookie_port(addresses_)),
                .page_address = page_address(config_of(context), addresses_)} {}

  void start() {
    shared_.print_address();
    thread_ = std::thread([this] {
      set_thread_up("web");
      shared_.loop.run();
      ended_.set_value();
    });
  }

  void take(std::size_t address, int descriptor, std::shared_ptr<Account> account) {
    Account* const own = account.get();
    // With the last of the connection's copies of this.
    std::shared_ptr<Account> held(own,
                                  [account = std::move(account)](Account*) { account->leave(); });
    asio::post(shared_.loop, [this, address, descriptor, held = std::move(held)] {
      begin(addresses_[address], descriptor, held);
    });
  }

  void stop(core::Duration grace) {
    if (!thread_.joinable()) return;
    asio::post(shared_.loop, [this] { guard_.reset(); });
    const auto ended = ended_.get_future();
    if (ended.wait_for(grace) != std::future_status::ready) {
      asio::post(shared_.loop, [this] {
        stopping_ = true;
        for (const auto& each : shared_.open) {
          if (const auto connection = each.lock()) connection->cut();
        }
      });
    }
    thread_.join();
  }

 private:
  static WebConfig config_of(const ServiceContext& context) {
    return context.config.web.value_or(WebConfig{});
  }

  void begin(const FrontConfig::Address& address, int descriptor,
             std::shared_ptr<Account> account) {
    const PeerName name = peer_name(descriptor);
    sockaddr_storage own{};
    socklen_t size = sizeof own;
    if (stopping_ || name.owner.empty() ||
        getsockname(descriptor, reinterpret_cast<sockaddr*>(&own), &size) != 0) {
      ::close(descriptor);
      return;
    }
    WebPeer peer;
    peer.use = address.use;
    peer.unix_socket = name.grpc.empty();
    peer.peer.encrypted = encrypts(address.protection);
    peer.peer.this_host = address.protection == Protection::kThisHost;
    peer.peer.account = std::move(account);
    asio::generic::stream_protocol::socket socket(
        shared_.loop, asio::generic::stream_protocol(own.ss_family, 0), descriptor);
    PlainStream plain(std::move(socket));
    const bool encrypted = peer.peer.encrypted;
    const auto connection = std::make_shared<HttpConnection>(
        encrypted ? WebStream(std::move(plain), *tls_) : WebStream(std::move(plain)), shared_,
        std::move(peer));
    shared_.add(connection);
    if (!encrypted) return connection->read();
    connection->stream().next_layer().expires_after(kHandshakeWithin);
    connection->stream().handshake(Completion([connection](beast::error_code error) {
      if (error) return;
      connection->peer().peer.names = certificate_names(connection->stream().tls());
      connection->read();
    }));
  }

  const Addresses& addresses_;
  const std::unique_ptr<asio::ssl::context> tls_;  ///< null: plain text
  WebShared shared_;
  std::optional<asio::executor_work_guard<asio::io_context::executor_type>> guard_{
      shared_.loop.get_executor()};
  bool stopping_{false};  ///< the loop's thread only
  std::promise<void> ended_{};
  std::thread thread_{};
};

WebServer::WebServer(ServiceContext& context, const WebContent& content,
                     const std::optional<TlsFiles>& tls, std::span<const Descriptor> token_files)
    : impl_(std::make_unique<Impl>(context, content, tls, token_files)) {}

WebServer::~WebServer() {
  stop(std::chrono::seconds(1));
}

void WebServer::start() {
  impl_->start();
}

void WebServer::take(std::size_t address, int descriptor, std::shared_ptr<Account> account) {
  impl_->take(address, descriptor, std::move(account));
}

void WebServer::stop(core::Duration grace) {
  impl_->stop(grace);
}

}  // namespace haptic::server
