#pragma once
/// The bytes of a web connection, in plain text or TLS (private to this folder).

#include <boost/container/static_vector.hpp>
#include <memory>
#include <utility>
#include <variant>

#include "server/front/web/beast.hpp"

namespace haptic::server {

/// The function that runs when an operation ends. One type for every operation: Beast's and TLS's
/// machinery is then compiled once, and not once for each pair of them.
class Completion {
 public:
  template <typename Handler>
  explicit Completion(Handler&& handler)
      : call_(std::make_unique<Held<std::decay_t<Handler>>>(std::forward<Handler>(handler))) {}

  void operator()(beast::error_code error, std::size_t bytes = 0) { call_->run(error, bytes); }

 private:
  struct Call {
    virtual ~Call() = default;
    virtual void run(beast::error_code error, std::size_t bytes) = 0;
  };
  template <typename Handler>
  struct Held final : Call {
    explicit Held(Handler from) : handler(std::move(from)) {}
    void run(beast::error_code error, std::size_t bytes) override {
      if constexpr (std::is_invocable_v<Handler&, beast::error_code, std::size_t>) {
        handler(error, bytes);
      } else {
        handler(error);
      }
    }
    Handler handler;
  };

  std::unique_ptr<Call> call_;
};

/// Handlers run on the executor of the socket, never inside the call that starts the operation.
class WebStream {
 public:
  using next_layer_type = PlainStream;
  using executor_type = PlainStream::executor_type;

  explicit WebStream(PlainStream plain) : stream_(std::move(plain)) {}
  WebStream(PlainStream plain, asio::ssl::context& tls)
      : stream_(std::in_place_type<TlsStream>, std::move(plain), tls) {}

  [[nodiscard]] executor_type get_executor() noexcept { return next_layer().get_executor(); }
  /// The socket, with its time limit.
  [[nodiscard]] PlainStream& next_layer() noexcept {
    TlsStream* const tls = std::get_if<TlsStream>(&stream_);
    return tls != nullptr ? tls->next_layer() : std::get<PlainStream>(stream_);
  }
  /// Null: plain text.
  [[nodiscard]] SSL* tls() noexcept {
    TlsStream* const tls = std::get_if<TlsStream>(&stream_);
    return tls != nullptr ? tls->native_handle() : nullptr;
  }

  /// Handshake of TLS; plain text needs none.
  void handshake(Completion done);

  template <typename Buffers, typename Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    read(some<asio::mutable_buffer>(buffers), Completion(std::forward<Handler>(handler)));
  }
  template <typename Buffers, typename Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    write(some<asio::const_buffer>(buffers), Completion(std::forward<Handler>(handler)));
  }
  /// Ends the stream after the last frame of a WebSocket.
  void tear_down(beast::role_type role, Completion done);

 private:
  /// Buffers that one system call moves at most; the rest waits for the next.
  template <typename Buffer>
  using Some = boost::container::static_vector<Buffer, 8>;

  template <typename Buffer, typename Buffers>
  static Some<Buffer> some(const Buffers& buffers) {
    Some<Buffer> first;
    for (auto each = asio::buffer_sequence_begin(buffers);
         each != asio::buffer_sequence_end(buffers) && first.size() < first.capacity(); ++each) {
      const Buffer buffer(*each);
      if (buffer.size() > 0) first.push_back(buffer);
    }
    return first;
  }

  void read(const Some<asio::mutable_buffer>& buffers, Completion done);
  void write(const Some<asio::const_buffer>& buffers, Completion done);

  std::variant<PlainStream, TlsStream> stream_;
};

/// Beast's WebSocket finds it by this name.
template <typename Handler>
void async_teardown(beast::role_type role, WebStream& stream, Handler&& handler) {
  stream.tear_down(role, Completion(std::forward<Handler>(handler)));
}

using WebSocket = websocket::stream<WebStream, false>;  ///< without compression

}  // namespace haptic::server
