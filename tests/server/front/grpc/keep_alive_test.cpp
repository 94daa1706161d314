/// Connections whose far end is gone without a word, seen from that end: HTTP/2 by hand (RFC 9113),
/// so that a ping may be left without an answer.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "server/front/grpc/rpc_server.hpp"
#include "tests/server/support/live_server.hpp"
#include "tests/support/file_text.hpp"

namespace haptic::test {
namespace {

using Clock = std::chrono::steady_clock;

/// The client's end of one connection.
class RawHttp2 {
 public:
  enum Type : std::uint8_t { kSettings = 4, kPing = 6 };
  static constexpr std::uint8_t kAck = 1;

  struct Frame {
    std::uint8_t type{0}, flags{0};
    std::string payload{};
  };

  explicit RawHttp2(const std::string& address) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    const auto colon = address.rfind(':');
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(colon + 1))));
    inet_pton(AF_INET, address.substr(0, colon).c_str(), &to.sin_addr);
    const timeval patience{30, 0};
    setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    connected_ = connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
    write("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n");
    send({kSettings, 0, {}});
  }
  ~RawHttp2() { close(socket_); }
  RawHttp2(const RawHttp2&) = delete;
  RawHttp2& operator=(const RawHttp2&) = delete;

  [[nodiscard]] bool connected() const { return connected_; }

  void send(const Frame& frame) {
    const auto size =
        static_cast<std::uint8_t>(frame.payload.size());  // none of ours is longer than 8
    const std::array<std::uint8_t, 9> head{0, 0, size, frame.type, frame.flags, 0, 0, 0, 0};
    write({head.begin(), head.end()});
    write(frame.payload);
  }

  /// The next frame, settings acknowledged on the way; none: the server closed the connection.
  std::optional<Frame> next() {
    for (;;) {
      const std::optional<std::string> head = read(9);
      if (!head) return std::nullopt;
      const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>((*head)[i]); };
      const std::size_t size = std::size_t{byte(0)} << 16U | std::size_t{byte(1)} << 8U | byte(2);
      std::optional<std::string> payload = read(size);
      if (!payload) return std::nullopt;
      if (byte(3) == kSettings && (byte(4) & kAck) == 0) {
        send({kSettings, kAck, {}});
        continue;
      }
      return Frame{byte(3), byte(4), std::move(*payload)};
    }
  }

 private:
  void write(const std::string& bytes) {
    // The reader sees what fails here.
    static_cast<void>(::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL));
  }
  std::optional<std::string> read(std::size_t size) {
    std::string bytes(size, '\0');
    for (std::size_t have = 0; have < size;) {
      const ssize_t n = recv(socket_, bytes.data() + have, size - have, 0);
      if (n <= 0) return std::nullopt;
      have += static_cast<std::size_t>(n);
    }
    return bytes;
  }

  int socket_;
  bool connected_{false};
};

server::ServiceLimits hasty() {
  return {.keep_alive = {300ms, 1700ms}};
}

TEST(KeepAlive, GivesUpAfterAnUnansweredPing) {
  LiveServer server({{"127.0.0.1:0"}}, patient_config(), {}, hasty());
  const Clock::time_point began = Clock::now();
  RawHttp2 client(server.address());
  ASSERT_TRUE(client.connected());
  int pings = 0;
  while (const auto frame = client.next()) {
    if (frame->type == RawHttp2::kPing) ++pings;
    ASSERT_LT(Clock::now() - began, 30s);
  }
  EXPECT_GE(pings, 1);
  EXPECT_GE(Clock::now() - began, hasty().keep_alive.given_up_after());
  // These times count, not those that are shipped.
  EXPECT_LT(Clock::now() - began, server::KeepAlive{}.ask_after);
}

TEST(KeepAlive, KeepsClientsThatAnswerPings) {
  LiveServer server({{"127.0.0.1:0"}}, patient_config(), {}, hasty());
  RawHttp2 client(server.address());
  ASSERT_TRUE(client.connected());
  const Clock::time_point began = Clock::now();
  // Longer than a silent one would have had, twice.
  for (int pings = 0;
       pings < 4 || Clock::now() - began < 2 * hasty().keep_alive.given_up_after();) {
    const auto frame = client.next();
    ASSERT_TRUE(frame) << "closed after " << pings << " pings that were answered";
    if (frame->type != RawHttp2::kPing || (frame->flags & RawHttp2::kAck) != 0) continue;
    client.send({RawHttp2::kPing, RawHttp2::kAck, frame->payload});
    ++pings;
  }
}

TEST(KeepAlive, MatchesTheProtocolAndIdleClients) {
  const server::KeepAlive shipped = server::ServiceLimits{}.keep_alive;
  const std::string text = file_text(HAPTIC_SOURCE_DIR "/proto/README.md");
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(shipped.given_up_after());
  EXPECT_NE(text.find("| connection without a sign of life | given up after " +
                      std::to_string(seconds.count()) + " s"),
            std::string::npos);
  // gRPC's poll of a connection without a call: every 5 s, and one may come late.
  EXPECT_GE(shipped.answer_within, 2 * 5s);
}

}  // namespace
}  // namespace haptic::test
