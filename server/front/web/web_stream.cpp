#include "server/front/web/web_stream.hpp"

namespace haptic::server {

void WebStream::handshake(Completion done) {
  std::get<TlsStream>(stream_).async_handshake(asio::ssl::stream_base::server, std::move(done));
}

void WebStream::read(const Some<asio::mutable_buffer>& buffers, Completion done) {
  std::visit([&](auto& stream) { stream.async_read_some(buffers, std::move(done)); }, stream_);
}

void WebStream::write(const Some<asio::const_buffer>& buffers, Completion done) {
  std::visit([&](auto& stream) { stream.async_write_some(buffers, std::move(done)); }, stream_);
}

void WebStream::tear_down(beast::role_type role, Completion done) {
  using websocket::async_teardown;
  std::visit([&](auto& stream) { async_teardown(role, stream, std::move(done)); }, stream_);
}

}  // namespace haptic::server
