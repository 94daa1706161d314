#include "server/owner/local/control_socket.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <filesystem>

#include "haptic/core/error.hpp"
#include "server/base/line_rate.hpp"
#include "server/crossing/packet_socket.hpp"
#include "tests/support/message_of.hpp"

namespace {

using haptic::core::TimePoint;
using haptic::server::ControlCommand;
using haptic::server::ControlPlaces;
using haptic::server::ControlSocket;
using haptic::server::Descriptor;
using haptic::server::parse_command;
using Kind = ControlCommand::Kind;

constexpr TimePoint kStart{std::chrono::seconds(100)};
constexpr unsigned kStranger = 65534;

/// The same in a child.
const std::string& name() {
  static const std::string made = "test-" + std::to_string(getpid());
  return made;
}

/// A local user's program.
class Caller {
 public:
  explicit Caller(const std::string& at = std::string(1, '\0') + "hapticd/" + name())
      : socket_(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    at.copy(address.sun_path, sizeof address.sun_path - 1);
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + at.size());
    connected_ = connect(socket_.get(), reinterpret_cast<sockaddr*>(&address), size) == 0;
  }
  [[nodiscard]] bool connected() const { return connected_; }
  [[nodiscard]] int descriptor() const { return socket_.get(); }
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

struct Folder {
  Folder() { std::filesystem::create_directory(path); }
  ~Folder() { std::filesystem::remove_all(path); }
  const std::string path{testing::TempDir() + name()};
};

struct Served {
  explicit Served(const std::string& folder = {}, ControlSocket::Barred barred = {})
      : socket(
            {folder, {name()}}, [this](const auto& c) { commands.push_back(c); },
            std::move(barred)) {}
  std::vector<ControlCommand> commands{};
  ControlSocket socket;
};

/// Runs `act` in a process of another user; its exit status.
int as_stranger(const auto& act) {
  const pid_t child = fork();
  if (child == 0) {
    const bool other = setgid(kStranger) == 0 && setuid(kStranger) == 0;
    _exit(other && act() ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

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
  EXPECT_EQ(parse_command("clear finger\n4294967296").wrong.rfind("refused", 0), 0U);
  EXPECT_EQ(parse_command("health\nnow").wrong.rfind("refused", 0), 0U);
}

TEST(ControlCommand, ALongReasonStopsToo) {
  const auto stop = parse_command("stop finger\n" + std::string(400, 'x'));
  EXPECT_EQ(stop.wrong, "");
  EXPECT_EQ(stop.command.device, "finger");
  EXPECT_EQ(parse_command("stop " + std::string(400, 'x') + "\ny").wrong, "refused: too long");
}

TEST(ControlSocket, ACommandGetsItsAnswer) {
  Served served;
  Caller caller;
  ASSERT_TRUE(caller.connected());
  ASSERT_TRUE(caller.say("stop finger"));
  served.socket.turn(kStart);
  ASSERT_EQ(served.commands.size(), 1U);
  EXPECT_EQ(served.commands[0].device, "finger");
  EXPECT_EQ(served.commands[0].user, geteuid());
  EXPECT_TRUE(served.commands[0].trusted);
  EXPECT_EQ(caller.answer(), "");
  served.socket.answer(served.commands[0].reply_to, "ok");
  EXPECT_EQ(caller.answer(), "ok");
}

TEST(ControlSocket, IdleCallersKeepNobodyOut) {
  Served served;
  std::vector<Caller> idle(5 * ControlSocket::kConnections);
  served.socket.turn(kStart);
  Caller caller;
  ASSERT_TRUE(caller.say("stop"));
  for (int i = 0; i < 10 && served.commands.empty(); ++i) served.socket.turn(kStart);
  ASSERT_EQ(served.commands.size(), 1U);
  std::vector<pollfd> wait;
  static_cast<void>(served.socket.add_to(wait, kStart));
  EXPECT_LE(wait.size(), ControlSocket::kConnections + 1);
}

TEST(ControlSocket, StopsGoFirst) {
  Served served;
  std::vector<Caller> callers(4);
  callers[0].say("clear finger");
  callers[1].say("restart-front");
  callers[2].say("health");
  callers[3].say("stop");
  served.socket.turn(kStart);
  ASSERT_EQ(served.commands.size(), 4U);
  EXPECT_EQ(served.commands[0].kind, Kind::kStop);
}

TEST(ControlSocket, JunkIsRefused) {
  Served served;
  Caller junk, endless;
  ASSERT_TRUE(junk.say("\x01\xff\x00 stop"));
  ASSERT_TRUE(endless.say(std::string(100'000, 's')));
  served.socket.turn(kStart);
  EXPECT_TRUE(served.commands.empty());
  EXPECT_EQ(junk.answer().rfind("refused", 0), 0U);
  EXPECT_EQ(endless.answer(), "refused: too long");
}

TEST(ControlSocket, ABarredProcessIsRefused) {
  Served served({}, [](pid_t process) { return process == getpid(); });
  for (const char* command : {"stop", "clear", "restart-front", "health"}) {
    Caller front;
    front.say(command);
    served.socket.turn(kStart);
    EXPECT_FALSE(front.say("stop")) << "it was closed";
  }
  EXPECT_TRUE(served.commands.empty());
}

TEST(ControlSocket, AnEndedProcessOnlyStops) {
  Served served;
  const pid_t child = fork();
  if (child == 0) _exit(Caller().say("stop") && Caller().say("clear finger") ? 0 : 1);
  int status = 1;
  waitpid(child, &status, 0);
  ASSERT_EQ(status, 0);
  served.socket.turn(kStart);
  ASSERT_EQ(served.commands.size(), 1U);
  EXPECT_EQ(served.commands[0].kind, Kind::kStop);
}

TEST(ControlSocket, ABurdenedMessageIsNotTaken) {
  Served served;
  Caller caller;
  const std::array descriptor{STDERR_FILENO};
  int on = 0;
  socklen_t size = sizeof on;
  const bool refused =
      getsockopt(caller.descriptor(), SOL_SOCKET, haptic::server::kPassRights, &on, &size) == 0;
  ASSERT_EQ(haptic::server::send(caller.descriptor(), 'x', descriptor), !refused);
  if (refused) return;  // by the kernel, from Linux 6.16 on
  served.socket.turn(kStart);
  EXPECT_TRUE(served.commands.empty()) << "to close what it brings may take long";
  EXPECT_FALSE(caller.say("stop")) << "it was closed";
}

TEST(ControlSocket, StrangersStopButClearNothing) {
  if (geteuid() != 0) GTEST_SKIP() << "another user's process needs root";
  Served served;
  as_stranger([] {
    Caller().say("stop");
    Caller().say("clear finger");
    return Caller().say("restart-front");
  });
  served.socket.turn(kStart);
  ASSERT_EQ(served.commands.size(), 1U);
  EXPECT_EQ(served.commands[0].kind, Kind::kStop);
  EXPECT_EQ(served.commands[0].user, kStranger);
  EXPECT_FALSE(served.commands[0].trusted);
}

TEST(ControlSocket, OneStrangerGetsFewPlaces) {
  if (geteuid() != 0) GTEST_SKIP() << "another user's process needs root";
  Served served;
  as_stranger([] {
    for (int i = 0; i < 40; ++i) Caller().say("stop");
    return true;
  });
  TimePoint now = kStart;
  served.socket.turn(now);
  EXPECT_LE(served.commands.size(), ControlSocket::kPerUser);
  // The queue is empty, and what comes next finds its place, in a later turn at the latest.
  as_stranger([] { return Caller().say("stop finger"); });
  served.commands.clear();
  served.socket.turn(now += ControlSocket::kRound);
  ASSERT_EQ(served.commands.size(), 1U);
}

TEST(ControlSocket, AFloodLeavesTurnsToTrusted) {
  if (geteuid() != 0) GTEST_SKIP() << "another user's process needs root";
  Served served;
  std::size_t strange = 0;
  for (int i = 0; i < 20; ++i) {
    as_stranger([] { return Caller().say("stop"); });
    served.socket.turn(kStart);
    strange = served.commands.size();
  }
  EXPECT_LE(strange, ControlSocket::kTurnsPerRound) << "in one round";
  std::vector<pollfd> wait;
  EXPECT_LE(served.socket.add_to(wait, kStart), ControlSocket::kRound);
  EXPECT_TRUE(wait.empty()) << "what is not served must not wake the thread";
  served.commands.clear();
  served.socket.turn(kStart + ControlSocket::kRound);
  EXPECT_FALSE(served.commands.empty()) << "in the next round they are served";
}

TEST(ControlListeners, NoFloodReachesTheOwnSocket) {
  if (geteuid() != 0) GTEST_SKIP() << "another user's process needs root";
  const Folder folder;
  const std::string path = folder.path + "/" + name();
  Served served(folder.path);
  EXPECT_NE(as_stranger([&] { return Caller(path).connected(); }), 0);
  EXPECT_EQ(as_stranger([&] { return Caller(path + ".all").connected(); }), 0);
  Caller own(path);
  ASSERT_TRUE(own.say("stop"));
  served.socket.turn(kStart);
  ASSERT_EQ(served.commands.size(), 1U);
  EXPECT_TRUE(served.commands[0].trusted);
}

TEST(ControlListeners, AStaleFileIsReplaced) {
  const Folder folder;
  const std::string path = folder.path + "/" + name();
  const Descriptor left(::socket(AF_UNIX, SOCK_SEQPACKET, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(bind(left.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  {
    const Served served(folder.path);
    EXPECT_TRUE(Caller(path).connected());
  }
  EXPECT_FALSE(std::filesystem::exists(path)) << "an end leaves no file";
}

TEST(ControlListeners, ATakenNameIsNotNeeded) {
  const Folder folder;
  const Served holder;  // any program of this host may have the abstract name
  EXPECT_THAT(haptic::test::message_of<haptic::core::TransportError>([] { Served(); }),
              testing::HasSubstr("in use by user " + std::to_string(geteuid()) +
                                 ", so that there would be no local stop: name a folder"));
  Served served(folder.path);
  Caller caller(folder.path + "/" + name());
  ASSERT_TRUE(caller.say("stop"));
  served.socket.turn(kStart);
  EXPECT_EQ(served.commands.size(), 1U);
  EXPECT_THROW(Served(folder.path), haptic::core::TransportError) << "a second daemon";
}

TEST(LineRate, TellsWhatItLeftOut) {
  haptic::server::LineRate lines;
  TimePoint now = kStart;
  for (unsigned i = 0; i < haptic::server::LineRate::kLinesPerSecond; ++i) {
    EXPECT_EQ(lines.next(now), std::optional<std::uint64_t>(0));
  }
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(lines.next(now), std::nullopt);
  now += std::chrono::seconds(1);
  EXPECT_EQ(lines.next(now), std::optional<std::uint64_t>(1000));
  EXPECT_EQ(lines.next(now), std::optional<std::uint64_t>(0));
}

}  // namespace
