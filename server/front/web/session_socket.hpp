#pragma once
/// A session's stream on a WebSocket (private to web_server.cpp): one message a frame.

#include <array>
#include <memory>
#include <string>
#include <utility>

#include "server/front/service/session_stream.hpp"
#include "server/front/session/refusals.hpp"
#include "server/front/web/http_answer.hpp"
#include "server/front/web/web_shared.hpp"
#include "server/front/web/web_stream.hpp"

namespace haptic::server {

inline constexpr std::string_view kProtoProtocol = "haptic.v1.proto";
inline constexpr std::string_view kJsonProtocol = "haptic.v1.json";
/// Beyond, the connection ends without a word; up to it the server says what is too large.
inline constexpr std::size_t kLargestFrame = 4 * kLargestMessage;
inline constexpr std::chrono::seconds kCloseWithin{2};

inline bool offers(std::string_view protocols, std::string_view wanted) {
  return http::token_list(to_beast(protocols)).exists(to_beast(wanted));
}

/// 1000, or 4000 and the canonical code, with "REASON: message".
inline websocket::close_reason close_reason_of(const std::optional<Refusal>& why) {
  if (!why) return {websocket::close_code::normal};
  const std::string words = why->reason.str() + ": " + why->message.str();
  const auto code = static_cast<websocket::close_code>(4000 + static_cast<int>(why->code));
  return {code, beast::string_view(sanitised(words, 123))};
}

class SessionSocket final : public SessionStream, public WebConnection {
 public:
  SessionSocket(WebStream stream, WebShared& shared, Peer peer, bool json)
      : SessionStream(shared.context, std::move(peer), Carrier::kWebSocket),
        shared_(shared),
        socket_(std::move(stream)),
        json_(json) {
    socket_.read_message_max(kLargestFrame);
    socket_.binary(!json);
    socket_.auto_fragment(false);
    const KeepAlive& alive = context_.limits.keep_alive;
    // Beast asks with a ping after half of it.
    socket_.set_option(websocket::stream_base::timeout{kCloseWithin, alive.given_up_after(), true});
    socket_.set_option(websocket::stream_base::decorator([json](websocket::response_type& head) {
      const std::string_view chosen = json ? kJsonProtocol : kProtoProtocol;
      head.set(http::field::sec_websocket_protocol, to_beast(chosen));
    }));
  }
  ~SessionSocket() override { done(); }

  /// On the server's thread, as all that follows but write() and finish().
  void accept(const http::request<http::string_body>& request) {
    socket_.async_accept(request, [self = self()](beast::error_code error) {
      if (!error) self->begin();
    });
  }
  void cut() override { beast::get_lowest_layer(socket_).close(); }

 private:
  [[nodiscard]] std::shared_ptr<SessionSocket> self() {
    return std::static_pointer_cast<SessionSocket>(shared_from_this());
  }

  void start_read() override {
    incoming_.consume(incoming_.size());
    socket_.async_read(incoming_, [self = self()](beast::error_code error, std::size_t bytes) {
      self->read(error, bytes);
    });
  }

  void read(beast::error_code error, std::size_t bytes) {
    const core::TimePoint arrival = context_.limits.clock({});
    if (error) return lost();
    if (!may_parse(bytes)) return;
    if (socket_.got_binary() == json_) {
      return unreadable(json_ ? "haptic.v1.json has text frames"
                              : "haptic.v1.proto has binary frames");
    }
    const auto data = incoming_.cdata();
    if (!json_) {
      if (!request_.ParseFromArray(data.data(), static_cast<int>(bytes))) {
        return unreadable("not a SessionRequest");
      }
    } else if (const std::string why =
                   Json::read({static_cast<const char*>(data.data()), bytes}, request_);
               !why.empty()) {
      return unreadable(why);
    }
    received(request_, bytes, arrival);
  }

  void write(Outgoing message) override {
    writing_ = true;
    asio::post(shared_.loop, [self = self(), message = std::move(message)]() mutable {
      self->write_now(std::move(message));
    });
  }

  void write_now(Outgoing message) {
    outgoing_ = std::move(message);
    if (json_) {
      std::string bytes = outgoing_.head;
      if (outgoing_.shared) bytes += *outgoing_.shared;
      outgoing_ = {shared_.json.from_bytes(*v1::SessionResponse::descriptor(), bytes), {}, {}};
    }
    static const std::string kNothing;
    const std::string& shared = outgoing_.shared ? *outgoing_.shared : kNothing;
    const std::array<asio::const_buffer, 2> parts{asio::buffer(outgoing_.head),
                                                  asio::buffer(shared)};
    socket_.async_write(
        parts, [self = self()](beast::error_code error, std::size_t) { self->written(!error); });
  }

  void finish(const std::optional<Refusal>& why) override {
    asio::post(shared_.loop, [self = self(), reason = close_reason_of(why)] {
      self->socket_.async_close(reason, [self](beast::error_code) { self->cut(); });
    });
  }

  WebShared& shared_;
  /// The loop goes on until its last words, from whichever thread, have come.
  const asio::executor_work_guard<asio::io_context::executor_type> loop_runs_{
      shared_.loop.get_executor()};
  WebSocket socket_;
  const bool json_;
  beast::flat_buffer incoming_{kLargestFrame};
  v1::SessionRequest request_;
  Outgoing outgoing_{};
};

}  // namespace haptic::server
