// A front's first words with its owner: what is handed over is checked before it is used.
#include "server/front/session/owner_link.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fcntl.h>

#include <cstring>

#include "haptic/core/error.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::server {
namespace {

using testing::HasSubstr;

/// An owner with one hand, by which it says its welcome.
class HelloTest : public testing::Test {
 protected:
  HelloTest() { config_.addresses = {{"127.0.0.1:1"}}; }

  /// The front's words about a welcome with the first `given` of its descriptors.
  std::string answer(const std::string& config, std::size_t given = 3) {
    std::tie(owner_, front_) = packet_pair();
    SharedMemory bytes("config", std::max<std::size_t>(config.size(), 1));
    std::memcpy(bytes.data(), config.data(), config.size());
    const Descriptor pages = pages_.for_reader(), its_config = bytes.for_reader();
    const Descriptor socket(open("/dev/null", O_CLOEXEC));
    const int all[] = {pages.get(), socket.get(), its_config.get(), socket.get(), socket.get()};
    OwnerMessage welcome;
    welcome.config_bytes = config.size();
    EXPECT_TRUE(send(owner_.get(), welcome, std::span(all, given)));
    link_.emplace(std::move(front_));
    return test::message_of<core::TransportError>([&] { start_ = link_->hello(); });
  }

  FrontConfig config_{};
  FrontStart start_{};
  std::optional<OwnerLink> link_{};
  Descriptor owner_{}, front_{};
  const SharedMemory pages_{"pages", OwnersPages::bytes(0)};
};

TEST_F(HelloTest, BringsConfigurationAndGoTheSockets) {
  EXPECT_EQ(answer(to_bytes(config_)), "no error");
  EXPECT_EQ(start_.config.addresses[0].name, "127.0.0.1:1");
  EXPECT_EQ(start_.files.size(), 0U);
  FrontMessage hello;
  ASSERT_EQ(receive(owner_.get(), hello), Received::kMessage);
  EXPECT_EQ(hello.kind, FrontMessage::Kind::kHello);
  EXPECT_EQ(hello.layout, layout_hash());
  const Descriptor socket(open("/dev/null", O_CLOEXEC));
  const int one = socket.get();
  EXPECT_TRUE(send(owner_.get(), OwnerMessage{OwnerMessage::Kind::kGo}, std::span(&one, 1)));
  EXPECT_EQ(link_->wait_for_go().value().size(), 1U);
  EXPECT_TRUE(send(owner_.get(), OwnerMessage{OwnerMessage::Kind::kGo}));
  EXPECT_THAT(test::message_of<core::TransportError>([&] { return link_->wait_for_go(); }),
              HasSubstr("go: has 0 descriptors: must have 1"));
  owner_ = Descriptor();
  EXPECT_FALSE(link_->wait_for_go());
}

TEST_F(HelloTest, WrongOnesAreRefused) {
  FrontConfig of_a_device = config_;
  of_a_device.devices.resize(1);
  const std::string good = to_bytes(config_);
  const struct {
    std::string config;
    std::size_t given;
    const char* says;
  } rows[] = {{good, 0, "has 0 descriptors: must have at least 3"},
              {good, 4, "has 4 descriptors: must have 3"},
              {good.substr(8), 3, "front configuration: "},
              {to_bytes(of_a_device), 3, "shared memory: has "}};
  for (const auto& [config, given, says] : rows) {
    EXPECT_THAT(answer(config, given), HasSubstr(says));
  }
}

}  // namespace
}  // namespace haptic::server
