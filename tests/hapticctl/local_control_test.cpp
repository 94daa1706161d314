#include "local_control.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "front_claims.hpp"
#include "haptic/wire/control_names.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::ctl {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsSupersetOf;
using testing::Not;

TEST(ControlNamesOf, EveryWayToWriteAnAddress) {
  for (const char* server :
       {"127.0.0.1:7", "ipv4:127.0.0.1:7", "dns:127.0.0.1:7", "dns:///127.0.0.1:7", "localhost:7",
        "LOCALHOST:7", "dns:localhost:7", "[::ffff:127.0.0.1]:7", "0.0.0.0:7"}) {
    EXPECT_THAT(control_names_of(server), Contains("127.0.0.1:7")) << server;
  }
  for (const char* server : {"[::1]:7", "ipv6:[::1]:7", "[0::0:1]:7"}) {
    EXPECT_THAT(control_names_of(server), Contains("[::1]:7")) << server;
  }
  char own[256]{};
  ASSERT_EQ(gethostname(own, sizeof own - 1), 0);
  EXPECT_THAT(control_names_of(own + std::string(":7")), Contains("127.0.0.1:7"));
}

TEST(ControlNamesOf, AllAddressesAreLookedAt) {
  EXPECT_THAT(control_names_of("127.0.0.2:7"), IsSupersetOf({"0.0.0.0:7", "[::]:7"}));
  EXPECT_THAT(control_names_of("[::1]:7"), Contains("[::]:7"));
  EXPECT_THAT(control_names_of("192.0.2.1:7"), Not(Contains("0.0.0.0:7"))) << "of another host";
}

TEST(ControlNamesOf, SocketsAndScenes) {
  EXPECT_EQ(control_names_of("unix:///no/s"), control_names_of("unix:/no/s"));
  EXPECT_THAT(control_names_of("local:my scene"), testing::ElementsAre("my scene"));
}

/// A user could put a link there, to the control socket of another hapticd.
TEST(AskLocally, AnothersFolderIsNotBelieved) {
  if (geteuid() != 0) GTEST_SKIP() << "to give a folder away needs root";
  const test::ScratchFolder folder;
  const std::filesystem::path own = folder.path() / "hapticd";
  std::filesystem::create_directory(own);
  const int listener = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  (own / wire::control_file("scene")).string().copy(name.sun_path, sizeof name.sun_path - 1);
  ASSERT_EQ(bind(listener, reinterpret_cast<const sockaddr*>(&name), sizeof name), 0);
  ASSERT_EQ(listen(listener, 4), 0);
  std::thread answers([listener] {
    for (int caller = 0; (caller = accept(listener, nullptr, nullptr)) >= 0; close(caller)) {
      std::array<char, 64> command{};
      recv(caller, command.data(), command.size(), 0);
      send(caller, "ok\nfinger", 9, MSG_NOSIGNAL);
    }
  });
  setenv("XDG_RUNTIME_DIR", folder.path().c_str(), 1);
  EXPECT_TRUE(ask_locally("local:scene", "stop"));
  EXPECT_EQ(chown(own.c_str(), 60'321, 60'321), 0);
  EXPECT_FALSE(ask_locally("local:scene", "stop"));
  unsetenv("XDG_RUNTIME_DIR");
  shutdown(listener, SHUT_RDWR);
  answers.join();
  close(listener);
}

TEST(FrontClaims, KernelsConnectionsAreCounted) {
  const std::string tcp =
      "  sl  local_address rem_address   st\n"
      "   0: 0100007F:731E 00000000:0000 0A\n"   // listens
      "   1: 0100007F:731E 0100007F:C1B4 01\n"   // the server's end
      "   2: 0100007F:C1B4 0100007F:731E 01\n";  // the client's
  const std::string local =
      "Num RefCount Protocol Flags Type St Inode Path\n"
      "0: 2 0 00010000 0001 01 1 /run/s\n"
      "0: 3 0 00000000 0001 03 2 /run/s\n"
      "0: 3 0 00000000 0001 03 3\n";
  EXPECT_EQ(count_connections({"127.0.0.1:29470"}, tcp, local), 1U);
  EXPECT_EQ(count_connections({"127.0.0.1:29470", "unix:/run/s"}, tcp, local), 2U);
  EXPECT_EQ(count_connections({"127.0.0.1:1"}, tcp, local), 0U);
}

TEST(FrontClaims, PlayingAClientIsSeen) {
  FrontClaims claims = front_claims({"front\tserves\t2\t77\t12\t", "address\t127.0.0.1:29470",
                                     "device\tfinger\tENGAGED\t1\t0\t5000\t998\t3\t1\tsoft grasp"});
  EXPECT_FALSE(claims.front_plays_a_client()) << "connections are not known";
  claims.connections = 1;
  EXPECT_THAT(to_text(claims), Not(HasSubstr("WARNING")));
  EXPECT_THAT(to_text(claims), HasSubstr("998/s accepted"));
  claims.connections = 0;
  EXPECT_THAT(to_text(claims), HasSubstr("the front plays a client"));
}

TEST(FrontClaims, AnEndedFrontSaysWhy) {
  const FrontClaims claims = front_claims({"front\tnone\t1\t0\t0\tthe certificate has expired"});
  EXPECT_THAT(to_text(claims), HasSubstr("no front serves"));
  EXPECT_THAT(to_text(claims), HasSubstr("the certificate has expired"));
}

}  // namespace
}  // namespace haptic::ctl
