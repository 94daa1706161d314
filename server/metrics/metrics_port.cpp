#include "server/metrics/metrics_port.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <list>
#include <optional>
#include <thread>
#include <utility>

#include "haptic/core/error.hpp"
#include "server/base/thread_setup.hpp"
#include "server/net/listen_address.hpp"

namespace haptic::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;

constexpr char kTextFormat[] = "text/plain; version=0.0.4; charset=utf-8";
/// Prometheus waits for 10 s, and is answered in milliseconds.
constexpr std::chrono::seconds kPatience{2};
/// Request line and header fields together; Prometheus sends 300 bytes.
constexpr std::uint32_t kLongestHeader = 8 * 1024;
/// Beyond, the oldest connection gives way.
constexpr std::size_t kConnections = 16;
/// When descriptors have run out.
constexpr std::chrono::milliseconds kRest{100};

using Page = std::function<std::string()>;

http::response<http::string_body> answer(http::status status, std::string text) {
  http::response<http::string_body> response(status, 11);
  response.set(http::field::content_type, kTextFormat);
  response.keep_alive(false);
  response.body() = std::move(text);
  response.prepare_payload();
  return response;
}

/// One connection: one request, whose body is not read, and one answer; all within kPatience.
class Scrape : public std::enable_shared_from_this<Scrape> {
 public:
  Scrape(tcp::socket socket, const Page& page) : stream_(std::move(socket)), page_(page) {
    parser_.header_limit(kLongestHeader);
  }

  void start() {
    stream_.expires_after(kPatience);
    http::async_read_header(
        stream_, buffer_, parser_,
        [self = shared_from_this()](beast::error_code error, std::size_t) { self->reply(error); });
  }
  void close() { stream_.close(); }

 private:
  void reply(beast::error_code error) {
    if (error == http::error::header_limit || error == http::error::buffer_overflow) {
      response_ = answer(http::status::request_header_fields_too_large, "header too large\n");
    } else if (error.category() == http::make_error_code(http::error::bad_method).category() &&
               error != http::error::end_of_stream && error != http::error::partial_message) {
      response_ = answer(http::status::bad_request, error.message() + "\n");
    } else if (error) {
      return;  // gone, or too slow
    } else {
      response_ = answer_to(parser_.get());
    }
    const bool head = !error && parser_.get().method() == http::verb::head;
    serializer_.emplace(response_);
    serializer_->split(head);
    const auto done = [self = shared_from_this()](beast::error_code, std::size_t) {
      beast::error_code ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    };
    if (head) return http::async_write_header(stream_, *serializer_, done);
    http::async_write(stream_, *serializer_, done);
  }

  http::response<http::string_body> answer_to(const http::request<http::empty_body>& request) {
    const auto target = request.target();
    if (target.substr(0, target.find('?')) != "/metrics") {
      return answer(http::status::not_found, "only /metrics is served\n");
    }
    if (request.method() != http::verb::get && request.method() != http::verb::head) {
      auto refused = answer(http::status::method_not_allowed, "GET only\n");
      refused.set(http::field::allow, "GET, HEAD");
      return refused;
    }
    return answer(http::status::ok, page_());
  }

  beast::tcp_stream stream_;
  const Page& page_;
  beast::flat_buffer buffer_{kLongestHeader};
  http::request_parser<http::empty_body> parser_{};
  http::response<http::string_body> response_{};
  std::optional<http::response_serializer<http::string_body>> serializer_{};
};

tcp::endpoint endpoint_of(asio::io_context& context, const std::string& listen) {
  const std::size_t colon = listen.rfind(':');
  std::string host = listen.substr(0, colon);
  // Without the brackets of a v6 literal, which are not part of the address.
  if (host.front() == '[') host = host.substr(1, host.size() - 2);
  tcp::resolver resolver(context);
  return *resolver.resolve(host, listen.substr(colon + 1), tcp::resolver::passive).begin();
}

}  // namespace

class MetricsPort::Impl {
 public:
  Impl(const std::string& listen, bool insecure_lab, Page page) : page_(std::move(page)) {
    if (listen.rfind("unix:", 0) == 0) {
      throw core::TransportError("metrics address '" + listen +
                                 "': must be host:port (Prometheus asks by TCP)");
    }
    check_listen_address(listen, insecure_lab ? Protection::kInsecureLab : Protection::kThisHost);
    try {
      const tcp::endpoint address = endpoint_of(context_, listen);
      acceptor_.open(address.protocol());
      acceptor_.set_option(tcp::acceptor::reuse_address(true));
      acceptor_.bind(address);
      acceptor_.listen();
    } catch (const boost::system::system_error& error) {
      throw core::TransportError("metrics address '" + listen +
                                 "': cannot be bound: " + error.code().message());
    }
    accept();
    thread_ = std::thread([this] {
      set_thread_up("metrics");
      context_.run();
    });
  }

  ~Impl() {
    context_.stop();
    thread_.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  [[nodiscard]] std::uint16_t port() const { return acceptor_.local_endpoint().port(); }

 private:
  void accept() {
    acceptor_.async_accept([this](beast::error_code error, tcp::socket socket) {
      if (error) {
        rest_.expires_after(kRest);
        return rest_.async_wait([this](beast::error_code) { accept(); });
      }
      open_.remove_if([](const auto& scrape) { return scrape.expired(); });
      if (open_.size() >= kConnections) {
        if (const auto oldest = open_.front().lock()) oldest->close();
        open_.pop_front();
      }
      const auto scrape = std::make_shared<Scrape>(std::move(socket), page_);
      open_.push_back(scrape);
      scrape->start();
      accept();
    });
  }

  const Page page_;
  asio::io_context context_{1};
  tcp::acceptor acceptor_{context_};
  asio::steady_timer rest_{context_};
  std::list<std::weak_ptr<Scrape>> open_{};
  std::thread thread_{};
};

MetricsPort::MetricsPort(const std::string& listen, bool insecure_lab,
                         std::function<std::string()> page)
    : impl_(std::make_unique<Impl>(listen, insecure_lab, std::move(page))) {}

MetricsPort::~MetricsPort() = default;

std::uint16_t MetricsPort::port() const noexcept {
  return impl_->port();
}

}  // namespace haptic::server
