#pragma once
/// A client on a WebSocket without a library: it writes samples, and reads what comes on a thread
/// of its own. One translation unit a program: Boost.Beast takes long to compile.

#include <atomic>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <filesystem>
#include <string>
#include <thread>

#include "haptic/v1/session.pb.h"
#include "tests/bench/product.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::bench {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using BareSocket = websocket::stream<tcp::socket, false>;

inline constexpr char kToken[] = "0123456789abcdef";

/// The web part of a scene, with kToken for a controller.
class BenchWeb {
 public:
  BenchWeb() { std::filesystem::permissions(file_.path(), std::filesystem::perms::owner_read); }
  [[nodiscard]] server::WebConfig config() const {
    server::WebConfig web;
    web.listen = {"127.0.0.1:0"};
    web.names = {"127.0.0.2"};  // a relay's
    web.tokens = {{"bench", file_.path(), {true, server::Priority::kPrimary}}};
    return web;
  }

 private:
  test::TemporaryFile file_{kToken, "token"};
};

/// A held proxy of the finger.
inline std::string sample(std::uint64_t seq) {
  v1::SessionRequest request;
  v1::ProxySample& proxy = *request.mutable_proxy();
  proxy.set_seq(seq);
  proxy.set_mode(v1::PROXY_MODE_HELD);
  proxy.set_source_time_ns(now_ns());
  proxy.add_position(0.4);
  proxy.add_position(0.5);
  return request.SerializeAsString();
}

class WebClient {
 public:
  explicit WebClient(const std::string& address, const std::string& token = kToken)
      : socket_(context_) {
    const std::size_t colon = address.rfind(':');
    asio::connect(
        beast::get_lowest_layer(socket_),
        tcp::resolver(context_).resolve(address.substr(0, colon), address.substr(colon + 1)));
    beast::get_lowest_layer(socket_).set_option(tcp::no_delay(true));
    socket_.set_option(websocket::stream_base::decorator([&token](websocket::request_type& head) {
      head.set(beast::http::field::sec_websocket_protocol, "haptic.v1.proto");
      head.set(beast::http::field::authorization, "Bearer " + token);
    }));
    socket_.handshake(address, "/haptic.v1.HapticService/Session");
    socket_.binary(true);
    reader_ = std::thread([this] {
      beast::flat_buffer buffer;
      beast::error_code error;
      while (!error) {
        buffer.clear();
        socket_.read(buffer, error);
        ++received_;
      }
    });
  }
  ~WebClient() {
    beast::error_code ignored;
    beast::get_lowest_layer(socket_).shutdown(tcp::socket::shutdown_both, ignored);
    reader_.join();
  }
  void write(const std::string& bytes) { socket_.write(asio::buffer(bytes)); }

  /// Asks for the lease.
  void control(double rate_hz) {
    v1::SessionRequest open = open_as(v1::ROLE_CONTROLLER);
    open.mutable_open()->set_nominal_rate_hz(rate_hz);
    write(open.SerializeAsString());
  }
  /// Asks for states.
  void observe(double rate_hz) {
    v1::SessionRequest open = open_as(v1::ROLE_OBSERVER);
    open.mutable_open()->set_state_rate_hz(rate_hz);
    write(open.SerializeAsString());
  }
  [[nodiscard]] std::uint64_t received() const { return received_; }

 private:
  static v1::SessionRequest open_as(v1::Role role) {
    v1::SessionRequest request;
    request.mutable_open()->set_role(role);
    request.mutable_open()->set_client_name("bench");
    return request;
  }

  asio::io_context context_{};
  BareSocket socket_;
  std::atomic<std::uint64_t> received_{0};
  std::thread reader_{};
};

}  // namespace haptic::bench
