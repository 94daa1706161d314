#include "server/owner/local/local_commands.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "tests/server/support/device_rig.hpp"

namespace haptic::test {
namespace {

using core::LifecycleState;
using testing::HasSubstr;

/// Connected; not if there is no such socket.
server::Descriptor caller_of(const std::string& name) {
  server::Descriptor caller(::socket(AF_UNIX, SOCK_SEQPACKET, 0));
  const timeval moment{0, 1000};
  setsockopt(caller.get(), SOL_SOCKET, SO_RCVTIMEO, &moment, sizeof moment);
  const std::string at = std::string(1, '\0') + "hapticd/" + name;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  at.copy(address.sun_path, sizeof address.sun_path);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + at.size());
  if (connect(caller.get(), reinterpret_cast<sockaddr*>(&address), size) != 0) return {};
  return caller;
}

/// A served device that a client presses, and its local control socket. The owner's clock is the
/// test's, the socket's thread is real.
class LocalRig : public server::FrontPort {
 public:
  static std::shared_ptr<LocalRig> make(pid_t launcher = 0) {
    auto made = std::make_shared<LocalRig>();
    made->rig.owner->connect(made);
    made->local.listen(
        {.places = {{}, {made->name}}, .addresses = {"127.0.0.1:1"}, .launcher = launcher});
    return made;
  }
  void on_answer(const server::Answer& answer) override { local.on_answer(answer); }

  /// The whole answer. Meanwhile the client streams on, a sample a tick.
  std::string ask(const std::string& command) {
    const server::Descriptor caller = caller_of(name);
    EXPECT_TRUE(caller);
    ::send(caller.get(), command.data(), command.size(), 0);
    char bytes[4096];
    ssize_t got = -1;
    for (int i = 0; i < 60'000 && got < 0; ++i) {
      rig.stream(1, 0.01);
      got = recv(caller.get(), bytes, sizeof bytes, 0);
    }
    return {bytes, got > 0 ? static_cast<std::size_t>(got) : 0};
  }

  const std::string name{"test-local-" + std::to_string(getpid())};
  DeviceRig rig;
  std::vector<std::uint64_t> restarts{};
  server::LocalCommands local{*rig.owner, [this](std::uint64_t reply_to) {
                                restarts.push_back(reply_to);
                                local.answer(reply_to, "ok\nrestarted");
                              }};
};

TEST(LocalCommands, AStopEndsForceAndStays) {
  const auto served = LocalRig::make();
  DeviceRig& rig = served->rig;
  rig.control();
  rig.press();
  ASSERT_GT(rig.device->force, 0.5);
  EXPECT_EQ(served->ask("stop\nbutton"), "ok\nrig");
  EXPECT_EQ(rig.device->force, 0.0);
  // The most privileged client goes on: it streams, clears and engages.
  std::string refusal;
  for (int i = 0; i < 20; ++i) {
    rig.sessions->clear_faults({}, [&](const auto& o) { refusal = o.refusal.reason.str(); });
    rig.stream(250, 0.01);
    EXPECT_EQ(refusal, "STOPPED_LOCALLY");
    EXPECT_EQ(rig.engage(), "NOT_ARMED");
    ASSERT_EQ(rig.device->force, 0.0);
    ASSERT_EQ(rig.state(), LifecycleState::kFault);
  }
  EXPECT_EQ(served->ask("clear rig\n128"), "ok\n128");
  EXPECT_NE(rig.state(), LifecycleState::kFault);
}

TEST(LocalCommands, WrongOnesSayWhy) {
  const auto served = LocalRig::make();
  EXPECT_EQ(served->ask("stop thumb"), "refused: there is no such device");
  EXPECT_THAT(served->ask("stop all of it"), HasSubstr("no such device"));
  EXPECT_THAT(served->ask("start"), HasSubstr("must be stop"));
}

TEST(LocalCommands, HealthShowsWhatTheFrontClaims) {
  const auto served = LocalRig::make();
  DeviceRig& rig = served->rig;
  EXPECT_THAT(served->ask("health"), HasSubstr("ok\nfront\tnone\t0\t0\t0\t"));
  rig.control("s1", "al\tice\n");
  rig.stream(100, 0.01);
  served->local.front({.serves = true, .process = 77, .number = 2, .why = "it was\nended"});
  const std::string text = served->ask("health");
  EXPECT_THAT(text, HasSubstr("front\tserves\t2\t77\t"));
  EXPECT_THAT(text,
              HasSubstr("it was\\x0aended\naddress\t127.0.0.1:1\ndevice\trig\tARMED\t1\t0\t"));
  EXPECT_THAT(text, HasSubstr("\tal\\x09ice\\x0a")) << "a name from outside is one field";
}

/// From its first moment on: nothing has to be told of it.
TEST(LocalCommands, NoFrontIsHeard) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  const std::string name = "test-local-" + std::to_string(getpid());
  const pid_t launcher = fork();
  if (launcher == 0) {
    setsid();
    char begin = 0;
    const bool told = read(ends[0], &begin, 1) == 1;
    const pid_t front = fork();
    int status = 1;
    if (front > 0) _exit(waitpid(front, &status, 0) == front && status == 0 ? 0 : 1);
    const server::Descriptor caller = caller_of(name);
    ::send(caller.get(), "stop", 4, MSG_NOSIGNAL);
    ssize_t got = -1;
    do {
      got = recv(caller.get(), &begin, 1, 0);
    } while (got < 0 && errno == EAGAIN);
    _exit(told && caller && got <= 0 ? 0 : 1);
  }
  const auto served = LocalRig::make(launcher);
  ASSERT_EQ(write(ends[1], "x", 1), 1);
  int status = 1;
  ASSERT_EQ(waitpid(launcher, &status, 0), launcher);
  EXPECT_EQ(status, 0);
  EXPECT_NE(served->rig.state(), LifecycleState::kFault);
}

TEST(LocalCommands, ARestartIsAnsweredLater) {
  const auto served = LocalRig::make();
  EXPECT_EQ(served->ask("restart-front"), "ok\nrestarted");
  EXPECT_EQ(served->restarts.size(), 1U);
}

}  // namespace
}  // namespace haptic::test
