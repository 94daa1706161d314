#pragma once
/// The front's composition: what faces the network, on top of an owner that it knows by OwnerPort
/// alone.
///
/// | thread     | what it owns                                     | how it stops                |
/// |------------|--------------------------------------------------|-----------------------------|
/// | main       | the FrontApp; waits for the owner's word         | hapticd-front ends          |
/// | owner link | what the owner tells: answers, events, states to | OwnerLink::stop()           |
/// |            | streams; the sign of life                        |                             |
/// | udp        | the UDP path's socket: samples in, challenges;   | UdpPort::stop(), by stop()  |
/// |            | only if the scene has udp_listen                 |                             |
/// | web        | WebSockets, calls by HTTP, scrapes; only if the  | FrontServer::shutdown()     |
/// |            | scene wants them                                 |                             |
/// | connec-    | accepts connections, counts their bytes          | FrontServer::shutdown()     |
/// | tions      |                                                  |                             |
/// | gRPC's     | calls                                            | FrontServer::shutdown()     |

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/crossing/ports.hpp"
#include "server/crossing/server_facts.hpp"
#include "server/crossing/shared_layout.hpp"
#include "server/front/web/web_content.hpp"
#include "server/owner/scene/scene.hpp"

namespace haptic::server {

class FrontServer;

struct FrontSources {
  OwnerPort* owner{nullptr};
  FactsProvider facts{};
  std::function<TickTotals(std::size_t device)> totals{};
  /// Says what this front has counted so far; the answer is that and what those before it did.
  /// None: there was none before.
  std::function<FrontCounters(const FrontCounters&)> count{};
};

class FrontApp {
 public:
  /// The sources must outlive this. `insecure_lab`: plain text on any address (ServiceConfig).
  FrontApp(const Scene& scene, bool insecure_lab, FrontSources sources, Page page = {});
  /// stop().
  ~FrontApp();
  FrontApp(const FrontApp&) = delete;
  FrontApp& operator=(const FrontApp&) = delete;

  /// Reads the files of TLS and leaves them: they are right. Throws TransportError.
  static void check(const Scene& scene);
  /// Binds and serves. Throws TransportError; what was started by then is stopped.
  void start();
  /// Ends streams and calls within about a second. Idempotent.
  void stop();

  /// The addresses that were bound, ports filled in; empty unless running.
  [[nodiscard]] std::vector<std::string> addresses() const;
  /// The metrics'; 0 if there are none.
  [[nodiscard]] std::uint16_t metrics_port() const;

 private:
  [[nodiscard]] std::string metrics() const;
  /// Counters of this front and of those before it.
  [[nodiscard]] FrontCounters counted() const;

  const std::string scene_name_;
  const bool insecure_lab_;
  const FrontSources sources_;
  std::unique_ptr<FrontServer> server_;
};

}  // namespace haptic::server
