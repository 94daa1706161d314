/// haptic-bench-web: one way from a WebSocket's write to the mailbox, against a bare echo by Beast of
/// messages as large, on the same host. All times are of this host's steady clock.
#include <spdlog/spdlog.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "haptic/v1/session.pb.h"
#include "tests/bench/paired.hpp"
#include "tests/bench/product.hpp"
#include "tests/support/temporary_file.hpp"

namespace {

using namespace haptic;
using namespace haptic::bench;
namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Socket = websocket::stream<tcp::socket, false>;

constexpr int kSamples = 150;  // per block
constexpr std::chrono::milliseconds kEvery{4};
constexpr char kToken[] = "0123456789abcdef";

std::string sample(std::uint64_t seq) {
  v1::SessionRequest request;
  v1::ProxySample& proxy = *request.mutable_proxy();
  proxy.set_seq(seq);
  proxy.set_mode(v1::PROXY_MODE_HELD);
  proxy.set_source_time_ns(now_ns());
  proxy.add_position(0.4);
  proxy.add_position(0.5);
  return request.SerializeAsString();
}

/// A client without a library: it writes samples, and reads what comes on a thread of its own.
class Client {
 public:
  explicit Client(const std::string& address) : socket_(context_) {
    const std::size_t colon = address.rfind(':');
    asio::connect(
        beast::get_lowest_layer(socket_),
        tcp::resolver(context_).resolve(address.substr(0, colon), address.substr(colon + 1)));
    beast::get_lowest_layer(socket_).set_option(tcp::no_delay(true));
    socket_.set_option(websocket::stream_base::decorator([](websocket::request_type& head) {
      head.set(beast::http::field::sec_websocket_protocol, "haptic.v1.proto");
      head.set(beast::http::field::authorization, std::string("Bearer ") + kToken);
    }));
    socket_.handshake(address, "/haptic.v1.HapticService/Session");
    socket_.binary(true);
    reader_ = std::thread([this] {
      beast::flat_buffer buffer;
      beast::error_code error;
      while (!error) {
        buffer.clear();
        socket_.read(buffer, error);
      }
    });
  }
  ~Client() {
    beast::error_code ignored;
    beast::get_lowest_layer(socket_).shutdown(tcp::socket::shutdown_both, ignored);
    reader_.join();
  }
  void write(const std::string& bytes) { socket_.write(asio::buffer(bytes)); }

  /// When each of `kSamples` was written, ns.
  std::vector<std::int64_t> write_samples() {
    std::vector<std::int64_t> written;
    auto next = std::chrono::steady_clock::now();
    for (int i = 0; i < kSamples; ++i) {
      next += kEvery;
      std::this_thread::sleep_until(next);
      written.push_back(now_ns());
      write(sample(written.size()));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return written;
  }

 private:
  asio::io_context context_{};
  Socket socket_;
  std::thread reader_{};
};

/// Echoes to one client at a time, and keeps when each message came.
class Bare {
 public:
  Bare() : thread_([this] { run(); }) {}
  ~Bare() {
    stopping_ = true;
    beast::error_code ignored;
    tcp::socket last(context_);
    static_cast<void>(last.connect(acceptor_.local_endpoint(), ignored));
    thread_.join();
  }
  [[nodiscard]] std::string address() const {
    return "127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port());
  }
  std::vector<std::int64_t> came{};  ///< ns; of the client that has gone

 private:
  void run() {
    while (true) {
      Socket socket(acceptor_.accept());
      if (stopping_) return;
      beast::get_lowest_layer(socket).set_option(tcp::no_delay(true));
      socket.set_option(websocket::stream_base::decorator([](websocket::response_type& head) {
        head.set(beast::http::field::sec_websocket_protocol, "haptic.v1.proto");
      }));
      beast::error_code error;
      socket.accept(error);
      socket.binary(true);
      came.clear();
      beast::flat_buffer buffer;
      while (!error) {
        buffer.clear();
        socket.read(buffer, error);
        came.push_back(now_ns());
        if (!error) socket.write(buffer.data(), error);
      }
    }
  }
  asio::io_context context_{};
  tcp::acceptor acceptor_{context_, {asio::ip::make_address("127.0.0.1"), 0}};
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

double product_block(Product& product) {
  std::vector<std::int64_t> written;
  {
    Client client(product.address(1));
    v1::SessionRequest open;
    open.mutable_open()->set_role(v1::ROLE_CONTROLLER);
    open.mutable_open()->set_client_name("bench");
    open.mutable_open()->set_nominal_rate_hz(250);
    client.write(open.SerializeAsString());
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    {
      const std::lock_guard lock(product.arrivals.mutex);
      product.arrivals.born.clear();
    }
    written = client.write_samples();
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // the force is gone
  std::vector<double> up;
  const std::lock_guard lock(product.arrivals.mutex);
  for (const auto& [seq, born] : product.arrivals.born) {
    if (seq == 0 || seq > written.size()) continue;
    up.push_back(static_cast<double>(born - written[seq - 1]) * 1e-3);
  }
  if (up.size() < kSamples / 2) throw std::runtime_error("too few samples arrived");
  return percentile(up, 0.5);
}

double bare_block(Bare& bare) {
  std::vector<std::int64_t> written;
  {
    Client client(bare.address());
    written = client.write_samples();
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  std::vector<double> up;
  for (std::size_t i = 0; i < written.size() && i < bare.came.size(); ++i) {
    up.push_back(static_cast<double>(bare.came[i] - written[i]) * 1e-3);
  }
  return percentile(up, 0.5);
}

}  // namespace

int main() {
  spdlog::set_level(spdlog::level::warn);  // sessions that come and go
  const test::TemporaryFile token(kToken, "token");
  std::filesystem::permissions(token.path(), std::filesystem::perms::owner_read);
  server::WebConfig web;
  web.listen = {"127.0.0.1:0"};
  web.tokens = {{"bench", token.path(), {true, server::Priority::kPrimary}}};
  Product product({"127.0.0.1:0"}, {}, nullptr, web);
  Bare bare;
  bench::print_header();
  bench::print(bench::compare(
      "WebSocket write -> mailbox one way p50", "bare echo by Beast", "us",
      [&] { return product_block(product); }, [&] { return bare_block(bare); }, 1.3, 20));
  return 0;
}
