#include "server/owner/local/control_socket.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstddef>

#include "haptic/core/error.hpp"

namespace {

using haptic::server::control_name;
using haptic::server::ControlSocket;
using haptic::server::Descriptor;
using haptic::server::parse_command;
using Kind = ControlSocket::Command::Kind;

std::string name() {
  return "hapticd/test-" + std::to_string(getpid());
}

/// A local user's program.
class Caller {
 public:
  Caller() : socket_(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    name().copy(address.sun_path + 1, sizeof address.sun_path - 1);
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name().size());
    connected_ = connect(socket_.get(), reinterpret_cast<sockaddr*>(&address), size) == 0;
  }
  [[nodiscard]] bool connected() const { return connected_; }
  bool say(std::string_view text) {
    return ::send(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL) ==
           static_cast<ssize_t>(text.size());
  }
  std::string answer() {
    std::array<char, 512> bytes{};
    const ssize_t got = recv(socket_.get(), bytes.data(), bytes.size(), 0);
    return got > 0 ? std::string(bytes.data(), static_cast<std::size_t>(got)) : std::string();
  }

 private:
  Descriptor socket_;
  bool connected_{false};
};

struct Served {
  std::vector<ControlSocket::Command> commands{};
  ControlSocket socket{name(), [this](const auto& command) { commands.push_back(command); }};
};

TEST(ControlCommand, NamesWhatIsAllowed) {
  EXPECT_EQ(parse_command("stop").command.kind, Kind::kStop);
  EXPECT_EQ(parse_command("stop finger\n").command.device, "finger");
  EXPECT_EQ(parse_command("restart-front").command.kind, Kind::kRestartFront);
  for (const char* wrong : {"", " ", "STOP", "stopp", "health finger", "restart-front now"}) {
    EXPECT_EQ(parse_command(wrong).wrong.rfind("refused: must be stop", 0), 0U) << wrong;
  }
  EXPECT_EQ(parse_command(std::string(400, 'x')).wrong, "refused: too long");
}

TEST(ControlCommand, SecondLineSaysMore) {
  EXPECT_EQ(parse_command("stop finger\nit burns").command.reason, "it burns");
  EXPECT_EQ(parse_command("stop\nit burns").command.device, "");
  EXPECT_EQ(parse_command("clear finger\n128").command.faults, 128U);
  EXPECT_EQ(parse_command("clear finger\n0x80").wrong.rfind("refused", 0), 0U);
  EXPECT_EQ(parse_command("health\nnow").wrong.rfind("refused", 0), 0U);
}

TEST(ControlName, FollowsTheFirstAddress) {
  EXPECT_EQ(control_name("127.0.0.1:29470"), "hapticd/127.0.0.1:29470");
  EXPECT_EQ(control_name("127.0.0.2:29470"), "hapticd/127.0.0.2:29470");
  EXPECT_EQ(control_name("offline"), "hapticd/offline");
  EXPECT_EQ(control_name("unix:/run/hapticd/s"), "hapticd/run/hapticd/s");
}

TEST(ControlSocket, ACommandGetsItsAnswer) {
  Served served;
  Caller caller;
  ASSERT_TRUE(caller.connected());
  ASSERT_TRUE(caller.say("stop finger"));
  served.socket.turn();
  ASSERT_EQ(served.commands.size(), 1U);
  EXPECT_EQ(served.commands[0].device, "finger");
  EXPECT_EQ(served.commands[0].user, geteuid());
  EXPECT_EQ(caller.answer(), "");
  served.socket.answer(served.commands[0].reply_to, "ok");
  EXPECT_EQ(caller.answer(), "ok");
}

TEST(ControlSocket, IdleCallersKeepNobodyOut) {
  Served served;
  std::vector<Caller> idle(5 * ControlSocket::kConnections);
  served.socket.turn();
  Caller caller;
  ASSERT_TRUE(caller.say("stop"));
  for (int i = 0; i < 10 && served.commands.empty(); ++i) served.socket.turn();
  ASSERT_EQ(served.commands.size(), 1U);
  std::vector<pollfd> wait;
  served.socket.add_to(wait);
  EXPECT_LE(wait.size(), ControlSocket::kConnections + 1);
}

TEST(ControlSocket, JunkIsRefused) {
  Served served;
  Caller junk, endless;
  ASSERT_TRUE(junk.say("\x01\xff\x00 stop"));
  ASSERT_TRUE(endless.say(std::string(100'000, 's')));
  served.socket.turn();
  EXPECT_TRUE(served.commands.empty());
  EXPECT_EQ(junk.answer().rfind("refused", 0), 0U);
  EXPECT_EQ(endless.answer(), "refused: too long");
}

TEST(ControlSocket, ASecondDaemonIsRefused) {
  Served served;
  EXPECT_THROW(ControlSocket(name(), {}), haptic::core::TransportError);
}

}  // namespace
