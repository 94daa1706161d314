#pragma once
/// HapticService on its addresses, by every carrier: gRPC, datagrams, WebSockets and HTTP. What
/// faces the network, on top of an owner that it knows by OwnerPort alone.
///
/// | thread     | what it owns                                     | how it stops                |
/// |------------|--------------------------------------------------|-----------------------------|
/// | main       | the FrontServer; waits for the owner's word      | hapticd-front ends          |
/// | owner link | what the owner tells: answers, events, states to | OwnerLink::stop()           |
/// |            | streams; the sign of life                        |                             |
/// | udp        | the UDP path's socket: samples in, challenges;   | UdpPort::stop()             |
/// |            | only if the scene has udp_listen                 |                             |
/// | web        | WebSockets, calls by HTTP, scrapes; only if the  | FrontServer::stop()         |
/// |            | scene wants them                                 |                             |
/// | connec-    | accepts connections, counts their bytes          | FrontServer::stop()         |
/// | tions      |                                                  |                             |
/// | look after | health, and calls and streams whose time is up   | FrontServer::stop()         |
/// | gRPC's     | calls                                            | FrontServer::stop()         |

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/crossing/front_config.hpp"
#include "server/crossing/shared_layout.hpp"
#include "server/front/net/tls_files.hpp"
#include "server/front/service/service_context.hpp"
#include "server/front/web/web_content.hpp"

namespace haptic::server {

class RpcServer;
class WebServer;

/// The owner's words about itself, and what browsers show.
struct FrontSources {
  FactsProvider facts{};
  std::function<TickTotals(std::size_t device)> totals{};
  /// Says what this front has counted so far; the answer is that and what those before it did.
  /// None: there was none before.
  std::function<FrontCounters(const FrontCounters&)> count{};
  Page page{};
};

class FrontServer {
 public:
  /// Reads and checks the files of `start`, opens none, and serves nothing yet. `owner` and what
  /// the sources use must outlive this. Throws core::TransportError naming the file that is wrong.
  FrontServer(FrontStart start, OwnerPort& owner, FrontSources sources, ServiceLimits limits = {});
  /// stop() with 1 s.
  ~FrontServer();
  FrontServer(const FrontServer&) = delete;
  FrontServer& operator=(const FrontServer&) = delete;

  /// Before start(), instead of FrontStart::sockets. From then on it only accepts, receives and
  /// sends by them. Throws core::TransportError: the UDP path's socket is none.
  void take(std::vector<Descriptor> sockets);
  /// Once: serves. Throws core::TransportError: too few descriptors or threads are allowed.
  void start();
  /// Refuses new calls, ends streams (UNAVAILABLE), waits for at most `grace`, then cuts what is
  /// still connected. Idempotent.
  void stop(core::Duration grace);

  [[nodiscard]] const FrontConfig& config() const noexcept { return context_->config; }
  /// The addresses of gRPC and of browsers, with a word on what protects each, for people.
  [[nodiscard]] std::vector<std::string> served() const;
  /// Sentences on certificates that end soon.
  [[nodiscard]] std::vector<std::string> warnings() const;
  /// Datagrams dropped since the start, by reason ("TAG", ...); empty without a UDP path.
  [[nodiscard]] std::vector<std::pair<std::string, std::uint64_t>> dropped_datagrams() const;
  /// Connections that are open, and how many were cut since the start because of their bounds.
  [[nodiscard]] std::pair<std::size_t, std::uint64_t> connections() const;

 private:
  void serve();
  void say_what_is_served() const;
  /// Until it is over: looks at what no event brings up, the health of the devices and calls and
  /// streams whose time is up.
  void look_after(const std::stop_token& over);
  [[nodiscard]] std::string metrics() const;
  /// Counters of this front and those before it.
  [[nodiscard]] FrontCounters counted() const;

  const FrontSources sources_;
  const std::shared_ptr<ServiceContext> context_;  ///< the owner may be calling it still
  std::vector<Descriptor> sockets_;                ///< until start()
  WebContent content_{};
  std::vector<CertificateEnd> ends_{};
  std::unique_ptr<RpcServer> rpc_;
  std::unique_ptr<WebServer> web_{};  ///< null: nothing is served over HTTP
  std::jthread looks_{};
};

}  // namespace haptic::server
