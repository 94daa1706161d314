#pragma once
/// The HTTP port that answers scrapes: GET /metrics, nothing else. Header, time and connections are
/// bounded, bodies are not read. Boost.Beast stays behind this header.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace haptic::server {

class MetricsPort {
 public:
  /// Binds `listen`, "host:port" (port 0: any free one), beyond loopback only with `insecure_lab`,
  /// and serves; `page` is called for every scrape, on this port's one thread. Throws
  /// TransportError.
  MetricsPort(const std::string& listen, bool insecure_lab, std::function<std::string()> page);
  /// Waits for no scraper, only for the page that is being written.
  ~MetricsPort();
  MetricsPort(const MetricsPort&) = delete;
  MetricsPort& operator=(const MetricsPort&) = delete;

  [[nodiscard]] std::uint16_t port() const noexcept;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptic::server
