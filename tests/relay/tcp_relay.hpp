#pragma once
/// The relay's connections (private to tests/relay).

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>

#include <memory>
#include <set>

#include "tests/relay/timed_link.hpp"

namespace haptic::test {

class TcpConnection;

class TcpRelay {
 public:
  using Endpoint = asio::ip::tcp::endpoint;
  TcpRelay(asio::io_context& context, RelayClock& clock, const Scenario& scenario,
           const Endpoint& listen, const Endpoint& server);

 private:
  void accept();

  asio::io_context& context_;
  RelayClock& clock_;
  const Scenario scenario_;
  const Endpoint server_;
  asio::ip::tcp::acceptor acceptor_;
  std::uint64_t connections_{0};
};

}  // namespace haptic::test
