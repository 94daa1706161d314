// The configuration of a front, as bytes and back.
#include "server/crossing/front_config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "haptic/core/error.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::server {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using Use = FrontConfig::Use;

/// Every optional part is there, and every text holds what separated words once.
FrontConfig full() {
  FrontConfig config;
  config.scene = "a scene";
  config.log_level = "warn";
  config.addresses = {{"unix:/a folder/s", Use::kGrpc, Protection::kThisHost, 1},
                      {"localhost:7", Use::kWeb, Protection::kTls, 2},
                      {"0.0.0.0:9", Use::kMetrics, Protection::kInsecureLab, 1}};
  config.udp_listen = "127.0.0.1:8";
  config.max_sessions = 3;
  config.period = 2ms;
  config.tls = TlsConfig{"/a b.pem", "/c.key", "/d.pem", {{"surgeon", Priority::kOperator}}};
  config.web = WebConfig{{"localhost:0"},
                         {"robot"},
                         {"https://twin.example"},
                         {{"unity", "/t", {true, Priority::kPrimary}}},
                         {true, Priority::kPrimary}};
  config.insecure_lab = true;
  config.devices = {{"left", std::string("\0\1\2", 3), {1ms, 2ms, 3ms}, 4s, 900},
                    {"right", std::string(100'000, 'x'), {}, 2s, 1200}};
  return config;
}

std::string refusal(std::string_view bytes) {
  return test::message_of<core::TransportError>([&] { return front_config(bytes); });
}

/// Where `part` begins in the bytes of `config`.
std::size_t at(const std::string& bytes, std::string_view part) {
  const std::size_t found = bytes.find(part);
  EXPECT_NE(found, std::string::npos);
  return found;
}

TEST(FrontConfig, ComesBackAsItWas) {
  const FrontConfig config = full();
  const std::string bytes = to_bytes(config);
  const FrontConfig back = front_config(bytes);
  EXPECT_EQ(to_bytes(back), bytes);
  EXPECT_EQ(back.addresses[0].name, "unix:/a folder/s");
  EXPECT_EQ(back.addresses[1].sockets, 2U);
  EXPECT_EQ(back.addresses[2].protection, Protection::kInsecureLab);
  EXPECT_EQ(back.period, 2ms);
  EXPECT_EQ(back.tls->key, "/c.key");
  EXPECT_EQ(back.tls->clients[0].highest, Priority::kOperator);
  EXPECT_TRUE(back.web->tokens[0].rights.control);
  EXPECT_EQ(back.devices[0].description, std::string("\0\1\2", 3));
  EXPECT_EQ(back.devices[0].staleness.fade_end, 3ms);
  EXPECT_EQ(back.devices[1].largest_state, 1200U);
  EXPECT_EQ(sockets_of(back), 5U);
  EXPECT_EQ(files_of(back), 5U);
}

TEST(FrontConfig, ShortBytesAreRefused) {
  const std::string bytes = to_bytes(full());
  for (std::size_t size = 0; size < bytes.size(); size += size < 1000 ? 1 : 997) {
    ASSERT_THAT(refusal({bytes.data(), size}), HasSubstr("front configuration: ")) << size;
  }
  EXPECT_THAT(refusal(bytes + "x"), HasSubstr("1 bytes follow"));
}

TEST(FrontConfig, ARefusalNamesTheField) {
  const std::string good = to_bytes(full());
  std::string bytes = good;
  bytes[at(good, "unity") - 1] = '\x7f';  // the highest byte of its length
  EXPECT_THAT(refusal(bytes), HasSubstr("web.tokens[0].name: "));
  bytes = good;
  bytes[at(good, "localhost:7") + 11 + 8] = 4;  // Use, then Protection
  EXPECT_THAT(refusal(bytes), HasSubstr("addresses[1].protection: 4: must be at most 3"));
  bytes = good;
  bytes[at(good, "surgeon") - 16] = 2;  // how many clients there are
  EXPECT_THAT(refusal(bytes), HasSubstr("tls.clients[1]."));
  bytes = good.substr(0, good.size() - 100'000);
  EXPECT_THAT(refusal(bytes), HasSubstr("devices[1].description: 100000"));
}

TEST(FrontConfig, DamagedBytesAreReadOrRefused) {
  FrontConfig config = full();
  config.devices.pop_back();
  const std::string good = to_bytes(config);
  std::mt19937 random(1);
  int read = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string bytes = good;
    bytes[random() % bytes.size()] = static_cast<char>(random());
    const std::string why = refusal(bytes);
    if (why != "no error") {
      EXPECT_THAT(why, HasSubstr("front configuration: "));
      continue;
    }
    ++read;  // in a text or a number that may have any value
    EXPECT_EQ(to_bytes(front_config(bytes)), bytes);
  }
  EXPECT_GT(read, 100);
  EXPECT_LT(read, 2000);
}

}  // namespace
}  // namespace haptic::server
