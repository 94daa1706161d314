/// Which host clients are told for the UDP path.

#include <gtest/gtest.h>

#include "server/front/udp/udp_port.hpp"
#include "server/owner/link/listeners.hpp"

namespace haptic::test {
namespace {

/// The host that a port at `bound` tells.
std::string host(const char* bound, const std::vector<std::string>& streams) {
  const server::Listeners listeners({.listen = {"127.0.0.1:0"}, .udp_listen = bound}, false);
  return server::UdpPort(std::move(listeners.sockets().back()), streams).host();
}

TEST(UdpHost, IsAbsentIfClientKnowsBetter) {
  // Streams at the same address: behind a relay or a translator that has another name.
  EXPECT_EQ(host("127.0.0.1:0", {"127.0.0.1:0"}), "");
  EXPECT_EQ(host("127.0.0.1:0", {"localhost:0"}), "");
  EXPECT_EQ(host("127.0.0.1:0", {"127.0.0.3:0", "127.0.0.1:0"}), "");
  EXPECT_EQ(host("127.0.0.1:0", {"127.0.0.1:0", "unix:/tmp/x"}), "");
}

TEST(UdpHost, IsToldIfClientCannotGuess) {
  EXPECT_EQ(host("127.0.0.1:0", {"127.0.0.2:0"}), "127.0.0.1");
  EXPECT_EQ(host("127.0.0.1:0", {"unix:/tmp/x"}), "127.0.0.1");
  EXPECT_EQ(host("127.0.0.2:0", {"127.0.0.2:0", "unix:/tmp/x"}), "127.0.0.2");
}

}  // namespace
}  // namespace haptic::test
