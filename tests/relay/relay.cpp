#include "tests/relay/relay.hpp"

#include <asio/executor_work_guard.hpp>
#include <asio/io_context.hpp>

#include <optional>
#include <stdexcept>
#include <thread>

#include "tests/relay/tcp_relay.hpp"
#include "tests/relay/udp_relay.hpp"

namespace haptic::test {
namespace {

template <typename Endpoint>
Endpoint endpoint(const std::string& host, std::uint16_t port) {
  asio::error_code error;
  const auto address = asio::ip::make_address(host, error);
  if (error) throw std::runtime_error("relay: host '" + host + "': must be an IP address");
  return {address, port};
}

}  // namespace

class Relay::Impl {
 public:
  explicit Impl(const RelaySetup& setup) {
    bind(setup);
    thread_ = std::thread([this] { context_.run(); });
  }
  ~Impl() {
    context_.stop();
    thread_.join();
  }

 private:
  void bind(const RelaySetup& setup) {
    std::uint16_t port = setup.tcp_port;
    try {
      if (port != 0) {
        tcp_.emplace(context_, clock_, setup.scenario,
                     endpoint<TcpRelay::Endpoint>(setup.listen_host, port),
                     endpoint<TcpRelay::Endpoint>(setup.server_host, port));
      }
      port = setup.udp_port;
      if (port != 0) {
        udp_.emplace(context_, clock_, setup.scenario,
                     endpoint<UdpRelay::Endpoint>(setup.listen_host, port),
                     endpoint<UdpRelay::Endpoint>(setup.server_host, port), setup.attacker);
      }
    } catch (const std::system_error& error) {
      throw std::runtime_error("relay: " + setup.listen_host + ":" + std::to_string(port) + ": " +
                               error.what());
    }
  }

  RelayClock clock_{};
  // Destroyed last, together with the objects that its last handlers keep alive.
  asio::io_context context_{1};
  asio::executor_work_guard<asio::io_context::executor_type> busy_{context_.get_executor()};
  std::optional<TcpRelay> tcp_{};
  std::optional<UdpRelay> udp_{};
  std::thread thread_{};
};

Relay::Relay(const RelaySetup& setup) : impl_(std::make_unique<Impl>(setup)) {}
Relay::~Relay() = default;

}  // namespace haptic::test
