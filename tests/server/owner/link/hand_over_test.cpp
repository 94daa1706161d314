// Files and sockets that the owner opens for its fronts.
#include "server/owner/link/hand_over.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/filter.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>

#include "haptic/core/error.hpp"
#include "server/crossing/packet_socket.hpp"
#include "tests/support/message_of.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::server {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

template <typename Act>
std::string refusal(const Act& act) {
  return test::message_of<core::TransportError>(act);
}

class NamedFileTest : public testing::Test {
 protected:
  NamedFileTest() { fs::permissions(file_.path(), fs::perms::owner_read | fs::perms::owner_write); }
  /// Opens `file` as a token.
  [[nodiscard]] std::string opened(const fs::path& file) const {
    FrontConfig config;
    config.web = WebConfig{};
    config.web->tokens = {{"unity", file, {}}};
    return refusal([&] { EXPECT_EQ(open_files(config, "/no/page").size(), 2U); });
  }

  const test::TemporaryFile file_{"0123456789abcdef\n", "unity.token"};
  const test::ScratchFolder folder_{};
};

TEST_F(NamedFileTest, OpensPlainFilesAndLinks) {
  EXPECT_EQ(opened(file_.path()), "no error");
  const fs::path link = folder_.path() / "link";  // as certbot's are
  fs::create_symlink(file_.path(), link);
  EXPECT_EQ(opened(link), "no error");
}

TEST_F(NamedFileTest, AFifoIsRefusedWithoutWaiting) {
  const fs::path fifo = folder_.path() / "fifo";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_THAT(opened(fifo), HasSubstr("must be a plain file"));
  EXPECT_THAT(opened(fifo), HasSubstr("server.web.token 'unity': file = '" + fifo.string() + "'"));
}

TEST_F(NamedFileTest, FoldersDevicesAndNothingAreRefused) {
  EXPECT_THAT(opened(folder_.path()), HasSubstr("must be a plain file"));
  EXPECT_THAT(opened("/dev/zero"), HasSubstr("must be a plain file"));
  EXPECT_THAT(opened(folder_.path() / "none"), HasSubstr("cannot be read"));
}

TEST_F(NamedFileTest, ALargeFileIsRefused) {
  fs::resize_file(file_.path(), (1 << 20) + 1);
  EXPECT_THAT(opened(file_.path()), HasSubstr("has more than 1 MB"));
}

TEST_F(NamedFileTest, AnotherUsersSecretIsRefused) {
  if (geteuid() != 0) GTEST_SKIP() << "to give a file away needs root";
  ASSERT_EQ(chown(file_.path().c_str(), 65534, 65534), 0);
  EXPECT_THAT(opened(file_.path()), HasSubstr("belongs to user 65534"));
}

TEST_F(NamedFileTest, OpenSecretsAreRefused) {
  for (const int mode : {0644, 0604, 0602, 0620}) {
    fs::permissions(file_.path(), static_cast<fs::perms>(mode));
    EXPECT_THAT(opened(file_.path()), HasSubstr("chmod 600")) << std::oct << mode;
  }
  FrontConfig config;
  config.tls = TlsConfig{.certificate = file_.path(), .key = file_.path()};
  EXPECT_THAT(refusal([&] { return open_files(config, {}); }), HasSubstr("server.tls.key"));
  fs::permissions(file_.path(), static_cast<fs::perms>(0640));
  EXPECT_EQ(opened(file_.path()), "no error");
}

std::uint16_t port(const Descriptor& socket) {
  sockaddr_storage name{};
  socklen_t size = sizeof name;
  EXPECT_EQ(getsockname(socket.get(), reinterpret_cast<sockaddr*>(&name), &size), 0);
  std::uint16_t number = 0;  // at the same place in every family
  std::memcpy(&number, reinterpret_cast<const char*>(&name) + 2, sizeof number);
  return number;
}

bool listens(const Descriptor& socket) {
  int value = 0;
  socklen_t size = sizeof value;
  getsockopt(socket.get(), SOL_SOCKET, SO_ACCEPTCONN, &value, &size);
  return value == 1;
}

/// A TCP and a UDP socket, and one with a path.
class ListenersTest : public testing::Test {
 protected:
  /// Copies, as a front gets them.
  std::vector<Descriptor> sockets() { return listeners_.sockets(); }
  /// They serve, and no other program gets the port.
  void expect_well() {
    const std::vector<Descriptor> now = sockets();
    ASSERT_EQ(now.size(), 3U);
    EXPECT_TRUE(listens(now[0]));
    EXPECT_TRUE(listens(now[1]));
    EXPECT_EQ(port(now[0]), port_);
    EXPECT_NE(port(now[2]), 0);
    sockaddr_storage peer{};
    socklen_t size = sizeof peer;
    EXPECT_EQ(getpeername(now[2].get(), reinterpret_cast<sockaddr*>(&peer), &size), -1);
    EXPECT_THAT(refusal([&] { const Listeners other({.listen = {address()}}, false); }),
                HasSubstr("in use"));
    EXPECT_THAT(refusal([&] { const Listeners other({.listen = {path_}}, false); }),
                HasSubstr("in use"));
  }
  [[nodiscard]] std::string address() const { return listeners_.addresses()[0].name; }

  const test::ScratchFolder folder_{};
  const std::string path_{"unix:" + (folder_.path() / "a b").string()};
  Listeners listeners_{{.listen = {"127.0.0.1:0", path_}, .udp_listen = "127.0.0.1:0"}, false};
  const std::uint16_t port_{port(listeners_.sockets()[0])};
};

TEST_F(ListenersTest, EveryFrontGetsTheSame) {
  expect_well();
  listeners_.check();
  expect_well();
}

TEST_F(ListenersTest, ChangedOnesAreOpenedAgain) {
  const auto change = [this](const auto& act) {
    act(sockets());
    listeners_.check();
    expect_well();
  };
  change([](const auto& had) { shutdown(had[0].get(), SHUT_RDWR); });
  change([](const auto& had) { shutdown(had[1].get(), SHUT_RDWR); });
  change([](const auto& had) {
    sockaddr_in away{};
    away.sin_family = AF_INET;
    away.sin_port = htons(9);
    away.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ASSERT_EQ(connect(had[2].get(), reinterpret_cast<sockaddr*>(&away), sizeof away), 0);
  });
  for (const std::size_t socket : {0U, 2U}) {
    change([socket](const auto& had) {
      sock_filter drop{BPF_RET | BPF_K, 0, 0, 0};
      const sock_fprog program{1, &drop};
      const int on = 1, off = 0;
      setsockopt(had[socket].get(), SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program);
      setsockopt(had[socket].get(), SOL_SOCKET, SO_LOCK_FILTER, &on, sizeof on);
      setsockopt(had[socket].get(), SOL_SOCKET, SO_REUSEPORT, &off, sizeof off);
      fcntl(had[socket].get(), F_SETFL, 0);
    });
  }
  for (const Descriptor& each : sockets()) EXPECT_NE(fcntl(each.get(), F_GETFL) & O_NONBLOCK, 0);
}

TEST_F(ListenersTest, CallersSendNoDescriptors) {
  const Descriptor caller(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  int on = 1;
  socklen_t size = sizeof on;
  if (getsockopt(caller.get(), SOL_SOCKET, kPassRights, &on, &size) != 0) {
    GTEST_SKIP() << "needs Linux 6.16";
  }
  const auto sends = [&] {
    const std::array<int, 1> sent{caller.get()};
    return send_bytes(caller.get(), std::as_bytes(std::span("x")), {}, sent);
  };
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  path_.copy(name.sun_path, sizeof name.sun_path - 1, 5);
  ASSERT_EQ(connect(caller.get(), reinterpret_cast<const sockaddr*>(&name), sizeof name), 0);
  EXPECT_FALSE(sends());
  const Descriptor taken(accept(sockets()[1].get(), nullptr, nullptr));
  ASSERT_TRUE(taken);
  EXPECT_FALSE(sends());
}

TEST_F(ListenersTest, OldCopiesServeNoMore) {
  const std::vector<Descriptor> had = sockets();
  listeners_.try_to_open_again();
  expect_well();
  EXPECT_FALSE(listens(had[0]));
}

TEST_F(ListenersTest, AnothersFileStays) {
  const std::string path = path_.substr(5);
  fs::remove(path);
  std::ofstream(path) << "precious";
  listeners_.try_to_open_again();
  listeners_.check();
  EXPECT_TRUE(fs::is_regular_file(path));
  EXPECT_TRUE(listens(sockets()[0])) << "the other addresses go on";
}

TEST(Listeners, AnAddressInUseIsNamed) {
  const test::ScratchFolder folder;
  const std::string path = "unix:" + (folder.path() / "socket").string();
  const auto refused = [](const ServerScene& scene) {
    return refusal([&] { const Listeners listeners(scene, false); });
  };
  for (const std::string& address : {std::string("127.0.0.1:0"), path}) {
    const Listeners first({.listen = {address}, .udp_listen = "127.0.0.1:0"}, false);
    const std::string taken = first.addresses()[0].name, udp = first.udp_listen();
    EXPECT_THAT(refused({.listen = {taken}}), AllOf(HasSubstr(taken), HasSubstr("in use")));
    EXPECT_THAT(refused({.listen = {"127.0.0.1:0"}, .udp_listen = udp}),
                AllOf(HasSubstr(udp), HasSubstr("in use")));
  }
  EXPECT_EQ(refused({.listen = {path}}), "no error") << "its server ended";
  EXPECT_THAT(refused({.listen = {path}, .udp_listen = "0.0.0.0:0"}), HasSubstr("server.tls"));
}

TEST(Listeners, AFullQueueMeansInUse) {
  const test::ScratchFolder folder;
  const std::string path = (folder.path() / "full").string();
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  path.copy(name.sun_path, sizeof name.sun_path - 1);
  const auto* const address = reinterpret_cast<const sockaddr*>(&name);
  const Descriptor server(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  ASSERT_EQ(bind(server.get(), address, sizeof name), 0);
  ASSERT_EQ(listen(server.get(), 0), 0);
  std::vector<Descriptor> callers;
  do {
    callers.emplace_back(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  } while (connect(callers.back().get(), address, sizeof name) == 0);
  ASSERT_EQ(errno, EAGAIN);
  EXPECT_THAT(refusal([&] { const Listeners other({.listen = {"unix:" + path}}, false); }),
              HasSubstr("in use by another process"));
}

TEST(HandOver, TooMuchIsRefused) {
  FrontConfig config;
  config.addresses = {{"127.0.0.1:1", FrontConfig::Use::kGrpc, Protection::kThisHost, 251}};
  EXPECT_THAT(refusal([&] { static_cast<void>(to_memory(config)); }),
              HasSubstr("254 descriptors: at most 253"));
  config.addresses.clear();
  config.devices = {{"hand", std::string(kLargestConfig, 'x'), {}, {}, 0}};
  EXPECT_THAT(refusal([&] { static_cast<void>(to_memory(config)); }),
              HasSubstr("bytes: at most 4194304"));
}

}  // namespace
}  // namespace haptic::server
