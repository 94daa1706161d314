#pragma once
/// The relay's connections (private to tests/relay).

#include <asio/buffer.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/write.hpp>

#include <array>
#include <deque>
#include <memory>
#include <utility>

#include "tests/relay/timed_link.hpp"

namespace haptic::test {

using asio::ip::tcp;

/// A segment on an Ethernet, lost or late as a whole.
inline constexpr std::size_t kSegment = 1448;
/// At most so much is under way in one direction, as in a TCP window; then the sender is not read.
inline constexpr std::size_t kWindow = 256 * 1024;

/// The first seed of a stream, as in the virtual matrix.
inline constexpr std::uint64_t kStreamSeed = 2000;

/// Both directions of a connection. Kept alive by its own reads and writes.
class TcpConnection : public std::enable_shared_from_this<TcpConnection> {
 public:
  TcpConnection(asio::io_context& context, RelayClock& clock, const Scenario& scenario,
                std::uint64_t number, tcp::socket client)
      : client_(std::move(client)),
        server_(context),
        up_(*this, client_, server_, context, clock,
            ReliableLink(scenario.up, scenario.seed + kStreamSeed + 10'000 * number)),
        down_(*this, server_, client_, context, clock,
              ReliableLink(scenario.down, scenario.seed + kStreamSeed + 1000 + 10'000 * number)) {}

  void start(const tcp::endpoint& server) {
    server_.async_connect(server, [self = shared_from_this()](asio::error_code error) {
      if (error) return self->close();
      asio::error_code ignored;
      self->client_.set_option(tcp::no_delay(true), ignored);
      self->server_.set_option(tcp::no_delay(true), ignored);
      self->up_.read();
      self->down_.read();
    });
  }

 private:
  struct Way {
    Way(TcpConnection& connection, tcp::socket& source, tcp::socket& sink,
        asio::io_context& context, RelayClock& clock, ReliableLink link)
        : owner(connection),
          from(source),
          to(sink),
          trouble(context, clock, std::move(link), [this](Packet p) { arrive(std::move(p)); }) {}

    void read() {
      if (reading || ended || under_way >= kWindow) return;
      reading = true;
      from.async_read_some(asio::buffer(buffer), [this, self = owner.shared_from_this()](
                                                     asio::error_code error, std::size_t size) {
        reading = false;
        if (error == asio::error::eof) {
          ended = true;
          return finish();
        }
        if (error) return owner.close();
        under_way += size;
        trouble.send({buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(size)});
        read();
      });
    }

    void arrive(Packet packet) {
      waiting.push_back(std::move(packet));
      if (waiting.size() == 1) write();
    }

    void write() {
      asio::async_write(
          to, asio::buffer(waiting.front()),
          [this, self = owner.shared_from_this()](asio::error_code error, std::size_t size) {
            if (error) return owner.close();
            under_way -= size;
            waiting.pop_front();
            if (!waiting.empty()) write();
            read();
            finish();
          });
    }

    /// The end of a stream follows its last byte.
    void finish() {
      if (!ended || under_way > 0 || told) return;
      told = true;
      asio::error_code ignored;
      to.shutdown(tcp::socket::shutdown_send, ignored);
      owner.way_ended();
    }

    TcpConnection& owner;
    tcp::socket& from;
    tcp::socket& to;
    TimedLink<ReliableLink> trouble;
    std::array<std::uint8_t, kSegment> buffer{};
    std::deque<Packet> waiting{};
    std::size_t under_way{0};
    bool reading{false}, ended{false}, told{false};
  };

  void way_ended() {
    if (up_.told && down_.told) close();
  }
  /// Bytes still under way are dropped, as by a reset.
  void close() {
    up_.trouble.close();
    down_.trouble.close();
    asio::error_code ignored;
    client_.close(ignored);
    server_.close(ignored);
  }

  tcp::socket client_, server_;
  Way up_, down_;
};

class TcpRelay {
 public:
  using Endpoint = tcp::endpoint;
  TcpRelay(asio::io_context& context, RelayClock& clock, const Scenario& scenario,
           const Endpoint& listen, const Endpoint& server)
      : context_(context),
        clock_(clock),
        scenario_(scenario),
        server_(server),
        acceptor_(context, listen) {
    accept();
  }

 private:
  void accept() {
    acceptor_.async_accept([this](asio::error_code error, tcp::socket client) {
      if (error == asio::error::operation_aborted) return;
      if (!error) {
        std::make_shared<TcpConnection>(context_, clock_, scenario_, connections_++,
                                        std::move(client))
            ->start(server_);
      }
      accept();
    });
  }

  asio::io_context& context_;
  RelayClock& clock_;
  const Scenario scenario_;
  const Endpoint server_;
  tcp::acceptor acceptor_;
  std::uint64_t connections_{0};
};

}  // namespace haptic::test
