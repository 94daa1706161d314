#pragma once
/// Who may use the service over HTTP (proto/README.md#the-web): by the name that the request is
/// addressed to, the web page that it comes from, and a token or a certificate. No transport.

#include <deque>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/crossing/outcome.hpp"
#include "server/crossing/web_config.hpp"
#include "server/front/service/peer.hpp"

namespace haptic::server {

/// A request as its head tells; the texts live as long as that.
struct Visitor {
  std::string_view host{};           ///< Host
  std::string_view origin{};         ///< Origin; empty: no web page
  std::string_view authorization{};  ///< Authorization
  std::string_view cookie{};         ///< Cookie
  std::string_view protocols{};      ///< Sec-WebSocket-Protocol
  bool encrypted{false};
  bool unix_socket{false};
  bool certificate{false};  ///< it showed one that was verified
};

/// One thread.
class Gate {
 public:
  static constexpr std::string_view kTokenProtocol = "haptic.token.";
  static constexpr std::size_t kCookies = 64;  ///< beyond, the oldest is forgotten

  /// Reads `token_files`, those of config.tokens. `names`: by which the listener is reached, lower
  /// case. `port`: tells its cookie from those of other servers of this host, which browsers keep
  /// together. Throws core::TransportError with the file and what is wrong, but never with what it
  /// holds.
  Gate(const WebConfig& config, std::span<const Descriptor> token_files,
       std::vector<std::string> names, const std::string& port = {});

  /// Refused: the Host is not served, or the Origin is a stranger.
  [[nodiscard]] std::optional<Refusal> stranger(const Visitor& visitor) const;
  /// The same for a scrape of metrics_listen. Refused: a Host that a web page elsewhere can have
  /// pointed here (DNS rebinding). It is none of the names, no literal address, and has a dot, as
  /// every name of the public DNS does.
  [[nodiscard]] std::optional<Refusal> strange_scrape(std::string_view host) const;
  /// True if the scene lists the origin of another site.
  [[nodiscard]] bool listed(std::string_view origin) const;
  /// Rights of a visitor who is no stranger; absent in the Outcome's value: what its certificate
  /// or the UNIX socket allows. Refused: it shows nothing that counts.
  [[nodiscard]] Outcome<std::optional<Rights>> rights(const Visitor& visitor) const;

  /// The name of its cookies.
  [[nodiscard]] const std::string& cookie() const noexcept { return cookie_; }
  /// The token of the next printed address.
  [[nodiscard]] const std::string& one_time() const noexcept { return one_time_; }
  /// If `token` is that: the secret of a cookie, and another token takes its place.
  [[nodiscard]] std::optional<std::string> redeem(std::string_view token);

 private:
  struct Secret {
    std::string text{};
    Rights rights{};
  };
  [[nodiscard]] const Secret* find(std::string_view text) const;

  const std::vector<std::string> names_;
  const std::string cookie_;
  const std::vector<std::string> origins_;
  const Rights printed_;
  std::vector<Secret> tokens_{};
  std::deque<Secret> cookies_{};
  std::string one_time_;
};

}  // namespace haptic::server
