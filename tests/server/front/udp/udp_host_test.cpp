/// Which host clients are told for the UDP path.

#include <gtest/gtest.h>

#include "server/front/udp/udp_port.hpp"

namespace haptic::test {
namespace {

using server::UdpPort;

TEST(UdpHost, IsAbsentIfClientKnowsBetter) {
  // Streams at the same address: behind a relay or a translator that has another name.
  EXPECT_EQ(UdpPort("127.0.0.1:0", {"127.0.0.1:0"}).host(), "");
  EXPECT_EQ(UdpPort("127.0.0.1:0", {"localhost:0"}).host(), "");
  EXPECT_EQ(UdpPort("127.0.0.1:0", {"127.0.0.3:0", "127.0.0.1:0"}).host(), "");
  EXPECT_EQ(UdpPort("127.0.0.1:0", {"127.0.0.1:0", "unix:/tmp/x"}).host(), "");
}

TEST(UdpHost, IsToldIfClientCannotGuess) {
  EXPECT_EQ(UdpPort("127.0.0.1:0", {"127.0.0.2:0"}).host(), "127.0.0.1");
  EXPECT_EQ(UdpPort("127.0.0.1:0", {"unix:/tmp/x"}).host(), "127.0.0.1");
  EXPECT_EQ(UdpPort("127.0.0.2:0", {"127.0.0.2:0", "unix:/tmp/x"}).host(), "127.0.0.2");
}

}  // namespace
}  // namespace haptic::test
