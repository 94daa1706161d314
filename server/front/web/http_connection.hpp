#pragma once
/// One connection of HTTP/1.1 (private to web_server.cpp): requests one after another, each within
/// bounds of size and time, until one of them becomes a WebSocket.

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "grpc/health/v1/health.pb.h"
#include "server/front/web/http_answer.hpp"
#include "server/front/web/session_socket.hpp"

namespace haptic::server {

inline constexpr std::chrono::seconds kHeadWithin{5}, kBodyWithin{5}, kAnswerWithin{30}, kIdle{30};
/// Request line and header fields together.
inline constexpr std::uint32_t kLongestHead = 8 * 1024;
inline constexpr std::size_t kDropped = 8 * 1024;  ///< at a time

class HttpConnection final : public WebConnection,
                             public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(WebStream stream, WebShared& shared, WebPeer peer)
      : stream_(std::move(stream)), shared_(shared), peer_(std::move(peer)) {}

  void read(std::chrono::seconds within = kHeadWithin) {
    parser_.emplace();
    parser_->header_limit(kLongestHead);
    parser_->body_limit(kLargestFrame);
    lowest().expires_after(within);
    http::async_read_header(
        stream_, buffer_, *parser_,
        [self = shared_from_this()](beast::error_code error, std::size_t bytes) {
          self->read_head(error, bytes);
        });
  }
  void cut() override { lowest().close(); }

  [[nodiscard]] WebStream& stream() noexcept { return stream_; }
  [[nodiscard]] WebPeer& peer() noexcept { return peer_; }

 private:
  using Head = http::request<http::string_body>;

  [[nodiscard]] PlainStream& lowest() { return stream_.next_layer(); }
  [[nodiscard]] const Head& head() const { return parser_->get(); }
  [[nodiscard]] std::string_view field(http::field name) const {
    const auto value = head().count(name) > 1 ? "told twice" : head()[name];  // of two, none counts
    return {value.data(), value.size()};
  }
  [[nodiscard]] std::string_view target() const {
    return {head().target().data(), head().target().size()};
  }
  [[nodiscard]] std::string_view path() const { return target().substr(0, target().find('?')); }
  [[nodiscard]] bool is(http::verb verb) const { return head().method() == verb; }

  void read_head(beast::error_code error, std::size_t bytes) {
    if (error == http::error::header_limit || error == http::error::buffer_overflow) {
      return refuse_head(http::status::request_header_fields_too_large, "header too large\n");
    }
    if (error == http::error::body_limit) {
      return refuse_head(http::status::payload_too_large, "body too large\n");
    }
    if (error.category() == http::make_error_code(http::error::bad_method).category() &&
        error != http::error::end_of_stream && error != http::error::partial_message) {
      return refuse_head(http::status::bad_request, error.message() + "\n");
    }
    if (error) return;  // gone, or too slow
    peer_.peer.account->call(bytes);
    if (peer_.use == FrontConfig::Use::kMetrics) return answer_scrape();
    const Visitor visitor = this->visitor();
    if (const auto strange = shared_.gate.stranger(visitor)) return refuse(*strange);
    if (websocket::is_upgrade(head())) return upgrade(visitor);
    if (is(http::verb::get) || is(http::verb::head)) return answer_get();
    if (is(http::verb::post)) return answer_post(visitor);
    if (is(http::verb::options)) return answer(http::status::no_content, "text/plain", {});
    refuse_head(http::status::method_not_allowed, "GET and POST only\n", "GET, HEAD, POST");
  }

  [[nodiscard]] Visitor visitor() const {
    return {field(http::field::host),
            field(http::field::origin),
            field(http::field::authorization),
            field(http::field::cookie),
            field(http::field::sec_websocket_protocol),
            peer_.peer.encrypted,
            peer_.unix_socket,
            !peer_.peer.names.empty()};
  }

  void answer_scrape() {
    if (const auto no = shared_.gate.strange_scrape(field(http::field::host))) return refuse(*no);
    if (path() != "/metrics") {
      return refuse_head(http::status::not_found, "only /metrics is served\n");
    }
    if (!is(http::verb::get) && !is(http::verb::head)) {
      return refuse_head(http::status::method_not_allowed, "GET only\n", "GET, HEAD");
    }
    closing_ = true;  // a scraper comes again
    answer_metrics();
  }
  void answer_metrics() {
    answer(http::status::ok, "text/plain; version=0.0.4; charset=utf-8", shared_.content.metrics());
  }

  void answer_get() {
    if (path() == "/metrics" && shared_.content.metrics) return answer_metrics();
    if (path() == "/healthz") {
      const bool serving = shared_.context.serving();
      return answer(serving ? http::status::ok : http::status::service_unavailable, "text/plain",
                    serving ? "SERVING\n" : "NOT_SERVING\n");
    }
    constexpr std::string_view kToken = "/?token=";
    if (is(http::verb::get) && target().starts_with(kToken)) {
      return redeem(target().substr(kToken.size()));
    }
    const Page& page = shared_.content.page;
    if (const auto file = page.find(path()); file != page.end()) {
      return answer(http::status::ok, file->second.type, {}, file->second.bytes);
    }
    if (path() == "/") {
      return answer(http::status::ok, "text/plain", std::string(kNoPage) + "\n");
    }
    answer(http::status::not_found, "text/plain", "not found\n");
  }

  void redeem(std::string_view token) {
    const auto secret = shared_.gate.redeem(token);
    if (secret) {
      rare_.cookie = shared_.gate.cookie() + "=" + *secret + "; HttpOnly; SameSite=Strict; Path=/";
      if (peer_.peer.encrypted) rare_.cookie += "; Secure";
      shared_.print_address();
    }
    // Away from the address with the token. If that is used up, the page says so.
    rare_.location = secret ? "/" : "/?used";
    answer(http::status::see_other, "text/plain", {});
  }

  void answer_post(const Visitor& visitor) {
    const bool health = path() == kHealthPath;
    const UnaryMethod* const method =
        path().starts_with(kService) ? find_method(path().substr(kService.size())) : nullptr;
    if (method == nullptr && !health) {
      return refuse({Refusal::Code::kNotFound, "NO_SUCH_CALL", "no such call"}, true);
    }
    const std::string_view type = field(http::field::content_type);
    const bool json = type.starts_with("application/json");
    if (!json && type != "application/proto") {
      return refuse_head(http::status::unsupported_media_type,
                         "Content-Type must be application/json or application/proto\n");
    }
    if (!health) {
      const auto rights = shared_.gate.rights(visitor);
      if (!rights) return refuse(rights.refusal, true);
      const bool control = !*rights.value || (*rights.value)->control;
      if (!method->observer && !control) return refuse(observes_only(), true);
    }
    lowest().expires_after(kBodyWithin);
    http::async_read(
        stream_, buffer_, *parser_,
        [self = shared_from_this(), method, json](beast::error_code error, std::size_t) {
          if (error) return;
          method == nullptr ? self->check_health(json) : self->call(*method, json);
        });
  }

  void call(const UnaryMethod& method, bool json) {
    const std::string& body = head().body();
    peer_.peer.account->call(body.size());
    if (const auto refusal = too_large(body.size())) return refuse(*refusal);
    const std::shared_ptr<OpenCall> open(
        new OpenCall{{}, BookedCall(peer_.peer.account), asio::make_work_guard(shared_.loop)});
    UnaryCall& call = open->call;
    method.make(call);
    if (const std::string why = Json::read(body, json, *call.request); !why.empty()) {
      call.readable = false;
      if (method.name != kStop) return refuse(unreadable(why));
    }
    lowest().expires_never();  // every call is answered in time
    Calls calls(shared_.context);
    method.run(calls, call, [self = shared_from_this(), open, json](const auto& why) {
      asio::post(self->shared_.loop, [self, open, json, why] {
        why ? self->refuse(*why) : self->answer_message(*open->call.response, json);
      });
    });
  }

  void check_health(bool json) {
    using grpc::health::v1::HealthCheckResponse;
    grpc::health::v1::HealthCheckRequest request;
    HealthCheckResponse response;
    if (const std::string why = Json::read(head().body(), json, request); !why.empty()) {
      return refuse(unreadable(why));
    }
    const ServiceContext& context = shared_.context;
    bool serving = false;
    if (request.service().empty()) {
      serving = context.serving();
    } else {
      const auto device = context.device(request.service());
      if (!device) return refuse(device.refusal);
      serving = context.serving(*device.value);
    }
    response.set_status(serving ? HealthCheckResponse::SERVING : HealthCheckResponse::NOT_SERVING);
    answer_message(response, json);
  }

  void upgrade(const Visitor& visitor) {
    if (path() != std::string(kService) + "Session") {
      return refuse({Refusal::Code::kNotFound, "NO_SUCH_CALL", "no such WebSocket"}, true);
    }
    const bool proto = offers(visitor.protocols, kProtoProtocol);
    if (!proto && !offers(visitor.protocols, kJsonProtocol)) {
      return refuse({Refusal::Code::kInvalid, "PROTOCOL",
                     "Sec-WebSocket-Protocol must offer haptic.v1.proto or haptic.v1.json"},
                    true);
    }
    const auto rights = shared_.gate.rights(visitor);
    if (!rights) return refuse(rights.refusal, true);
    Peer peer = peer_.peer;
    peer.token = *rights.value;
    lowest().expires_never();
    const auto socket =
        std::make_shared<SessionSocket>(std::move(stream_), shared_, std::move(peer), !proto);
    shared_.add(socket);
    socket->accept(head());
  }

  void answer_message(const google::protobuf::Message& message, bool json) {
    answer(http::status::ok, json ? "application/json" : "application/proto",
           json ? Json::from_message(message) : message.SerializeAsString());
  }
  [[nodiscard]] static Refusal unreadable(const std::string& why) {
    return {Refusal::Code::kInvalid, "PROTOCOL", why, "message"};
  }
  /// `unread`: its body is on the way still.
  void refuse(const Refusal& why, bool unread = false) {
    closing_ = closing_ || unread;
    answer(static_cast<http::status>(http_status(why.code)), "application/json",
           connect_error(why));
  }
  /// A request that HTTP itself refuses.
  void refuse_head(http::status status, std::string text, const char* allow = "") {
    closing_ = true;
    rare_.allow = allow;
    answer(status, "text/plain", std::move(text));
  }

  /// `file` lives as long as the server; absent: `text`.
  void answer(http::status status, std::string_view type, std::string text,
              std::optional<std::string_view> file = {}) {
    const bool read = parser_->is_header_done();
    if (read && shared_.gate.listed(field(http::field::origin))) {
      rare_.origin = field(http::field::origin);
    }
    text_ = std::move(text);
    answer_ = answer_of(status, type, file.value_or(text_), std::exchange(rare_, {}));
    // A body that was not read would pass for the next request.
    answer_.keep_alive(parser_->is_done() && head().keep_alive() && !closing_);
    serializer_.emplace(answer_);
    const bool no_body = read && is(http::verb::head);
    serializer_->split(no_body);
    lowest().expires_after(kAnswerWithin);
    auto sent = [self = shared_from_this()](beast::error_code error, std::size_t) {
      if (!error) self->answered();
    };
    if (no_body) return http::async_write_header(stream_, *serializer_, std::move(sent));
    http::async_write(stream_, *serializer_, std::move(sent));
  }

  void answered() {
    if (answer_.keep_alive()) return read(kIdle);
    beast::error_code ignored;
    lowest().socket().shutdown(asio::socket_base::shutdown_send, ignored);
    lowest().expires_after(kCloseWithin);
    drop_rest();
  }
  /// Reads what is still on its way: if the kernel had to refuse it, the answer would be lost too.
  void drop_rest() {
    buffer_.clear();
    lowest().async_read_some(buffer_.prepare(kDropped),
                             [self = shared_from_this()](beast::error_code error, std::size_t) {
                               if (!error) self->drop_rest();
                             });
  }

  WebStream stream_;
  WebShared& shared_;
  WebPeer peer_;
  beast::flat_buffer buffer_{kLongestHead + 8 * 1024};
  std::optional<http::request_parser<http::string_body>> parser_{};
  std::string text_{};
  RareFields rare_{};    ///< of the next answer
  bool closing_{false};  ///< after the next answer
  HttpAnswer answer_{};
  std::optional<http::response_serializer<AnswerBody>> serializer_{};
};

}  // namespace haptic::server
