#include "server/front/web/gate.hpp"

#include <arpa/inet.h>
#include <openssl/crypto.h>

#include <algorithm>
#include <utility>

#include "haptic/core/error.hpp"
#include "server/base/process.hpp"
#include "server/front/net/named_file.hpp"

namespace haptic::server {
namespace {

constexpr std::size_t kShortest = 16, kLongest = 128;

bool is_token(std::string_view text) {
  constexpr std::string_view kAllowed =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-";
  return text.size() >= kShortest && text.size() <= kLongest &&
         text.find_first_not_of(kAllowed) == std::string_view::npos;
}

std::string read_token(const WebToken& token, const Descriptor& file) {
  const std::string name =
      "server.web.token '" + token.name + "': file = '" + token.file.string() + "'";
  std::string line = read_named(name, file);
  if (line.ends_with('\n')) line.pop_back();
  if (is_token(line)) return line;
  throw core::TransportError(name + ": must hold 16 to 128 of [A-Za-z0-9_-] on one line");
}

Rights to_rights(const WebRights& rights, const std::string& bearer) {
  return {rights.highest, "with this token", bearer, rights.control};
}

std::string lower(std::string_view text) {
  std::string answer(text);
  for (char& c : answer) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return answer;
}

/// Without its port.
std::string_view name_of(std::string_view host) {
  if (host.starts_with('[')) return host.substr(0, host.find(']') + 1);
  return host.substr(0, host.find(':'));
}

/// Calls `visit` with the entries of a list, without blanks around them.
template <typename Visit>
void for_each_entry(std::string_view list, char separator, const Visit& visit) {
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(separator), list.size());
    std::string_view entry = list.substr(0, end);
    entry.remove_prefix(std::min(entry.find_first_not_of(" \t"), entry.size()));
    while (!entry.empty() && (entry.back() == ' ' || entry.back() == '\t')) entry.remove_suffix(1);
    if (!entry.empty()) visit(entry);
    list.remove_prefix(std::min(end + 1, list.size()));
  }
}

Refusal denied(const char* reason, const std::string& message) {
  return {Refusal::Code::kPermission, reason, message};
}

Refusal unknown_host() {
  return denied("HOST",
                "this server does not go by the name of the request's Host: give it in "
                "the scene, server.web.name");
}

/// "192.0.2.7", "[2001:db8::7]"
bool is_literal(std::string name) {
  in6_addr parsed{};
  if (!name.starts_with('[')) return inet_pton(AF_INET, name.c_str(), &parsed) == 1;
  return inet_pton(AF_INET6, name.substr(1, name.size() - 2).c_str(), &parsed) == 1;
}

}  // namespace

Gate::Gate(const WebConfig& config, std::span<const Descriptor> token_files,
           std::vector<std::string> names, const std::string& port)
    : names_(std::move(names)),
      cookie_(port.empty() ? "haptic" : "haptic-" + port),
      origins_(config.origins),
      printed_(to_rights(config.printed, "the printed address")),
      one_time_(random_secret()) {
  for (std::size_t i = 0; i < config.tokens.size(); ++i) {
    const WebToken& token = config.tokens[i];
    tokens_.push_back({read_token(token, token_files[i]),
                       to_rights(token.rights, "token of '" + token.name + "'")});
  }
}

bool Gate::listed(std::string_view origin) const {
  return std::find(origins_.begin(), origins_.end(), origin) != origins_.end();
}

std::optional<Refusal> Gate::strange_scrape(std::string_view host) const {
  const std::string name = lower(name_of(host));
  const bool known = std::find(names_.begin(), names_.end(), name) != names_.end();
  if (known || is_literal(name) || (!name.empty() && name.find('.') == std::string::npos)) {
    return std::nullopt;
  }
  return unknown_host();
}

std::optional<Refusal> Gate::stranger(const Visitor& visitor) const {
  if (!visitor.unix_socket) {
    const std::string name = lower(name_of(visitor.host));
    if (std::find(names_.begin(), names_.end(), name) == names_.end()) return unknown_host();
  }
  if (visitor.origin.empty() || listed(visitor.origin)) return std::nullopt;
  const std::string own = (visitor.encrypted ? "https://" : "http://") + std::string(visitor.host);
  if (!visitor.unix_socket && lower(visitor.origin) == lower(own)) return std::nullopt;
  return denied("ORIGIN", "a web page of another origin: list it in the scene, server.web.origin");
}

Outcome<std::optional<Rights>> Gate::rights(const Visitor& visitor) const {
  const Secret* shown = nullptr;
  const auto show = [&](std::string_view text) {
    if (shown == nullptr) shown = find(text);
  };
  constexpr std::string_view kBearer = "Bearer ";
  if (visitor.authorization.starts_with(kBearer)) {
    show(visitor.authorization.substr(kBearer.size()));
  }
  for_each_entry(visitor.protocols, ',', [&](std::string_view protocol) {
    if (protocol.starts_with(kTokenProtocol)) show(protocol.substr(kTokenProtocol.size()));
  });
  for_each_entry(visitor.cookie, ';', [&](std::string_view cookie) {
    const std::size_t name = cookie.find('=');
    if (cookie.substr(0, name) == cookie_ && name != std::string_view::npos) {
      show(cookie.substr(name + 1));
    }
  });
  if (shown != nullptr) return std::optional(shown->rights);
  if (visitor.unix_socket || visitor.certificate) return std::optional<Rights>();
  return Refusal{Refusal::Code::kUnauthenticated, "TOKEN",
                 "show a token: hapticd printed an address with one that can be used once, and a "
                 "scene has others, server.web.token"};
}

const Gate::Secret* Gate::find(std::string_view text) const {
  const auto same = [&](const Secret& secret) {
    return secret.text.size() == text.size() &&
           CRYPTO_memcmp(secret.text.data(), text.data(), text.size()) == 0;
  };
  if (const auto at = std::find_if(tokens_.begin(), tokens_.end(), same); at != tokens_.end()) {
    return &*at;
  }
  const auto at = std::find_if(cookies_.begin(), cookies_.end(), same);
  return at != cookies_.end() ? &*at : nullptr;
}

std::optional<std::string> Gate::redeem(std::string_view token) {
  if (token.size() != one_time_.size() ||
      CRYPTO_memcmp(token.data(), one_time_.data(), token.size()) != 0) {
    return std::nullopt;
  }
  one_time_ = random_secret();
  if (cookies_.size() >= kCookies) cookies_.pop_front();
  cookies_.push_back({random_secret(), printed_});
  return cookies_.back().text;
}

}  // namespace haptic::server
