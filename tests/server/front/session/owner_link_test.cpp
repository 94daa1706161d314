// A front's first words with its owner: what is handed over is checked before it is used.
#include "server/front/session/owner_link.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/eventfd.h>

#include <fcntl.h>

#include <cstring>

#include "haptic/core/error.hpp"

namespace haptic::server {
namespace {

using testing::HasSubstr;

/// An owner with one hand, by which it says its welcome.
class HelloTest : public testing::Test {
 protected:
  HelloTest() {
    config_.addresses = {{"127.0.0.1:1"}};
    std::tie(owner_, front_) = packet_pair();
  }

  /// The front's words about a welcome with the first `given` of its descriptors.
  std::string answer(const std::string& config, std::size_t given = 5) {
    SharedMemory bytes("config", std::max<std::size_t>(config.size(), 1),
                       SharedMemory::Access::kRead);
    std::memcpy(bytes.data(), config.data(), config.size());
    const Descriptor bell(eventfd(0, EFD_CLOEXEC)), socket(open("/dev/null", O_CLOEXEC));
    const int all[] = {pages_.descriptor(), own_.descriptor(), bell.get(),
                       bytes.descriptor(),  socket.get(),      socket.get()};
    OwnerMessage welcome;
    welcome.config_bytes = config.size();
    EXPECT_TRUE(send(owner_.get(), welcome, std::span(all, given)));
    OwnerLink link(std::move(front_));
    try {
      start_ = link.hello();
    } catch (const core::TransportError& error) {
      return error.what();
    }
    return {};
  }

  FrontConfig config_{};
  FrontStart start_{};
  Descriptor owner_{}, front_{};
  const SharedMemory pages_{"pages", OwnersPages::bytes(0), SharedMemory::Access::kRead};
  const SharedMemory own_{"own", sizeof(FrontsPages), SharedMemory::Access::kReadAndWrite};
};

TEST_F(HelloTest, BringsConfigurationAndSockets) {
  EXPECT_EQ(answer(to_bytes(config_)), "");
  EXPECT_EQ(start_.config.addresses[0].name, "127.0.0.1:1");
  EXPECT_EQ(start_.sockets.size(), 1U);
  EXPECT_EQ(start_.files.size(), 0U);
  FrontMessage hello;
  ASSERT_EQ(receive(owner_.get(), hello), Received::kMessage);
  EXPECT_EQ(hello.kind, FrontMessage::Kind::kHello);
  EXPECT_EQ(hello.layout, layout_hash());
}

TEST_F(HelloTest, WithoutDescriptorsIsRefused) {
  EXPECT_THAT(answer(to_bytes(config_), 0), HasSubstr("has 0 descriptors: must have at least 4"));
}

TEST_F(HelloTest, WithoutASocketIsRefused) {
  EXPECT_THAT(answer(to_bytes(config_), 4), HasSubstr("has 4 descriptors: must have 5"));
}

TEST_F(HelloTest, WithOneTooManyIsRefused) {
  EXPECT_THAT(answer(to_bytes(config_), 6), HasSubstr("has 6 descriptors: must have 5"));
}

TEST_F(HelloTest, DamagedConfigurationIsRefused) {
  EXPECT_THAT(answer(to_bytes(config_).substr(8)), HasSubstr("front configuration: "));
}

TEST_F(HelloTest, PagesOfOtherDevicesAreRefused) {
  config_.devices.resize(1);
  EXPECT_THAT(answer(to_bytes(config_)), HasSubstr("shared memory: has "));
}

}  // namespace
}  // namespace haptic::server
