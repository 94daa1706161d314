#pragma once
/// Answers of HTTP (private to web_server.cpp).

#include <string>
#include <string_view>
#include <utility>

#include "server/front/web/beast.hpp"

namespace haptic::server {

using AnswerBody = http::span_body<const char>;
using HttpAnswer = http::response<AnswerBody>;

/// Fields that few answers have; each empty: it is not there.
struct RareFields {
  std::string cookie{};       ///< Set-Cookie
  std::string location{};     ///< where the browser goes on
  const char* allow{""};      ///< methods
  std::string_view origin{};  ///< another web page's, which the scene lists
};

inline beast::string_view to_beast(std::string_view text) {
  return {text.data(), text.size()};
}

/// `bytes` must live until it is sent.
inline HttpAnswer answer_of(http::status status, std::string_view type, std::string_view bytes,
                            const RareFields& rare) {
  HttpAnswer answer(status, 11);
  const auto set = [&](auto field, std::string_view value) {
    if (!value.empty()) answer.set(field, to_beast(value));
  };
  set(http::field::content_type, type);
  set(http::field::cache_control, "no-store");
  set("X-Content-Type-Options", "nosniff");
  set("Referrer-Policy", "no-referrer");
  if (type.starts_with("text/html")) {
    set("Content-Security-Policy",
        "default-src 'self'; connect-src 'self' ws: wss:; img-src 'self' data: blob:; "
        "style-src 'self' 'unsafe-inline'; script-src 'self' 'wasm-unsafe-eval'; "
        "worker-src 'self' blob:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'");
  }
  set(http::field::set_cookie, rare.cookie);
  set(http::field::location, rare.location);
  set(http::field::allow, rare.allow);
  if (!rare.origin.empty()) {
    set(http::field::access_control_allow_origin, rare.origin);
    set(http::field::access_control_allow_methods, "GET, POST");
    set(http::field::access_control_allow_headers,
        "Authorization, Content-Type, Connect-Protocol-Version");
    set(http::field::vary, "Origin");
  }
  if (status == http::status::no_content) return answer;
  answer.body() = beast::span<const char>(bytes.data(), bytes.size());
  answer.content_length(bytes.size());
  return answer;
}

}  // namespace haptic::server
