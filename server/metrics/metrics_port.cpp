#include "server/metrics/metrics_port.hpp"

#include <httplib.h>

#include <chrono>
#include <thread>
#include <utility>

#include "haptic/core/error.hpp"
#include "server/base/thread_setup.hpp"
#include "server/net/listen_address.hpp"

namespace haptic::server {
namespace {

constexpr char kTextFormat[] = "text/plain; version=0.0.4; charset=utf-8";
/// A scraper that says nothing for this long is let go, so that it cannot hold the port or our end.
constexpr time_t kPatience_s = 2;

/// Without the brackets of a v6 literal, which are not part of the address.
std::string host_of(const std::string& listen) {
  std::string host = listen.substr(0, listen.rfind(':'));
  if (host.front() == '[') host = host.substr(1, host.size() - 2);
  return host;
}

}  // namespace

class MetricsPort::Impl {
 public:
  Impl(const std::string& listen, bool insecure_lab, std::function<std::string()> page)
      : page_(std::move(page)) {
    if (listen.rfind("unix:", 0) == 0) {
      throw core::TransportError("metrics address '" + listen +
                                 "': must be host:port (Prometheus asks by TCP)");
    }
    check_listen_address(listen, insecure_lab ? Protection::kInsecureLab : Protection::kThisHost);
    server_.new_task_queue = [] { return new httplib::ThreadPool(1); };
    // The library's default lets a second server share the port.
    server_.set_socket_options([](socket_t socket) {
      const int yes = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    server_.set_read_timeout(kPatience_s);
    server_.set_write_timeout(kPatience_s);
    server_.set_keep_alive_max_count(1);
    server_.set_payload_max_length(1024);
    server_.Get("/metrics", [this](const httplib::Request&, httplib::Response& response) {
      response.set_content(page_(), kTextFormat);
    });
    const int port = std::stoi(listen.substr(listen.rfind(':') + 1));
    port_ = port == 0 ? server_.bind_to_any_port(host_of(listen))
                      : (server_.bind_to_port(host_of(listen), port) ? port : -1);
    if (port_ <= 0) {
      throw core::TransportError("metrics address '" + listen +
                                 "': cannot be bound (in use, or not an address of this host)");
    }
    thread_ = std::thread([this] {
      set_thread_up("metrics");
      server_.listen_after_bind();
    });
    // stop() does nothing before the server runs.
    while (!server_.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  ~Impl() {
    server_.stop();
    thread_.join();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  [[nodiscard]] int port() const noexcept { return port_; }

 private:
  const std::function<std::string()> page_;
  httplib::Server server_{};
  int port_{0};
  std::thread thread_{};
};

MetricsPort::MetricsPort(const std::string& listen, bool insecure_lab,
                         std::function<std::string()> page)
    : impl_(std::make_unique<Impl>(listen, insecure_lab, std::move(page))) {}

MetricsPort::~MetricsPort() = default;

std::uint16_t MetricsPort::port() const noexcept {
  return static_cast<std::uint16_t>(impl_->port());
}

}  // namespace haptic::server
