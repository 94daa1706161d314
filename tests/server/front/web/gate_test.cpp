// Who may use the service over HTTP.
#include "server/front/web/gate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "haptic/core/error.hpp"
#include "server/owner/link/hand_over.hpp"
#include "tests/support/message_of.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::server {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr char kToken[] = "0123456789abcdef";

class GateTest : public testing::Test {
 protected:
  GateTest() {
    write(std::string(kToken) + "\n");
    config_.origins = {"https://twin.example"};
    config_.tokens = {{"unity", file_.path(), {true, Priority::kPrimary}}};
  }
  void write(const std::string& text) {
    file_.write(text);
    fs::permissions(file_.path(), fs::perms::owner_read | fs::perms::owner_write);
  }
  /// The owner opens them so for a front.
  [[nodiscard]] std::vector<Descriptor> token_files() const {
    FrontConfig config;
    config.web = config_;
    return open_files(config, {});
  }
  [[nodiscard]] Gate gate() const {
    return {config_, token_files(), {"127.0.0.1", "localhost", "lab.example"}};
  }
  [[nodiscard]] static Visitor at(std::string_view host, std::string_view origin = {}) {
    Visitor visitor;
    visitor.host = host;
    visitor.origin = origin;
    return visitor;
  }
  [[nodiscard]] std::string refusal() const {
    return test::message_of<core::TransportError>([&] { return gate(); });
  }

  test::TemporaryFile file_{"", "unity.token"};
  WebConfig config_{};
};

TEST_F(GateTest, NoPageElsewhereScrapes) {
  const Gate gate = this->gate();
  for (const char* host : {"127.0.0.1:29472", "[::1]:29472", "192.0.2.7:29472", "lab.example:1",
                           "LOCALHOST:29472", "left:29472"}) {
    EXPECT_FALSE(gate.strange_scrape(host)) << host;
  }
  for (const char* host : {"", ":29472", "rebound.example:29472", "127.0.0.1.rebound.example",
                           "left.", "[rebound.example]", "["}) {
    const auto refused = gate.strange_scrape(host);
    ASSERT_TRUE(refused) << host;
    EXPECT_EQ(refused->reason, "HOST") << host;
  }
}

TEST_F(GateTest, ServesItsNamesOnly) {
  const Gate gate = this->gate();
  for (const char* host : {"127.0.0.1:29473", "LOCALHOST", "lab.example:1"}) {
    EXPECT_FALSE(gate.stranger(at(host))) << host;
  }
  for (const char* host : {"evil.example", "", "lab.example.evil", "127.0.0.1.evil:80", "[::1]"}) {
    const auto refusal = gate.stranger(at(host));
    ASSERT_TRUE(refusal) << host;
    EXPECT_EQ(refusal->reason, "HOST");
  }
}

TEST_F(GateTest, ServesItsOwnAndListedOrigins) {
  const Gate gate = this->gate();
  EXPECT_FALSE(gate.stranger(at("localhost:1", "http://localhost:1")));
  EXPECT_FALSE(gate.stranger(at("localhost:1", "https://twin.example")));
  for (const char* origin : {"http://localhost", "http://localhost:2", "https://localhost:1",
                             "null", "http://twin.example", "http://evil.example"}) {
    const auto refusal = gate.stranger(at("localhost:1", origin));
    ASSERT_TRUE(refusal) << origin;
    EXPECT_EQ(refusal->reason, "ORIGIN");
  }
}

TEST_F(GateTest, TokenCountsWhereverItIsShown) {
  const Gate gate = this->gate();
  Visitor bearer, protocol;
  const std::string authorization = std::string("Bearer ") + kToken;
  bearer.authorization = authorization;
  const std::string protocols = std::string("haptic.v1.proto, haptic.token.") + kToken;
  protocol.protocols = protocols;
  for (const Visitor& visitor : {bearer, protocol}) {
    const auto rights = gate.rights(visitor);
    ASSERT_TRUE(rights) << rights.refusal.message;
    ASSERT_TRUE(rights.value->has_value());
    EXPECT_TRUE((*rights.value)->control);
    EXPECT_EQ((*rights.value)->highest, Priority::kPrimary);
    EXPECT_EQ((*rights.value)->bearer, "token of 'unity'");
  }
}

TEST_F(GateTest, RefusesWhoShowsNothing) {
  const Gate gate = this->gate();
  Visitor wrong;
  wrong.authorization = "Bearer 0123456789abcdee";
  Visitor half;
  half.cookie = "haptic=";
  for (const Visitor& visitor : {Visitor{}, wrong, half}) {
    const auto rights = gate.rights(visitor);
    ASSERT_FALSE(rights);
    EXPECT_EQ(rights.refusal.code, Refusal::Code::kUnauthenticated);
  }
}

TEST_F(GateTest, CertificateOrSocketNeedsNoToken) {
  const Gate gate = this->gate();
  Visitor visitor;
  visitor.certificate = true;
  EXPECT_FALSE(gate.rights(visitor).value.value().has_value());
  visitor = {};
  visitor.unix_socket = true;
  EXPECT_FALSE(gate.stranger(visitor));
  EXPECT_FALSE(gate.rights(visitor).value.value().has_value());
}

TEST_F(GateTest, PrintedTokenWorksOnce) {
  Gate gate = this->gate();
  const std::string token = gate.one_time();
  EXPECT_FALSE(gate.redeem(token.substr(1)));
  const auto secret = gate.redeem(token);
  ASSERT_TRUE(secret);
  EXPECT_FALSE(gate.redeem(token));
  EXPECT_NE(gate.one_time(), token);
  Visitor visitor;
  const std::string cookie = "a=b; haptic=" + *secret;
  visitor.cookie = cookie;
  EXPECT_FALSE(gate.rights(visitor).value.value()->control);
  for (std::size_t i = 0; i < Gate::kCookies; ++i) {
    ASSERT_TRUE(gate.redeem(std::string(gate.one_time())));
  }
  EXPECT_FALSE(gate.rights(visitor)) << "the oldest cookie is forgotten";
}

TEST_F(GateTest, CookiesOfTwoServersDiffer) {
  Gate one(config_, token_files(), {"localhost"}, "1");
  Gate other(config_, token_files(), {"localhost"}, "2");
  const std::string both = one.cookie() + "=" + *one.redeem(std::string(one.one_time())) + "; " +
                           other.cookie() + "=" + *other.redeem(std::string(other.one_time()));
  Visitor visitor;
  visitor.cookie = both;
  EXPECT_TRUE(one.rights(visitor));
  EXPECT_TRUE(other.rights(visitor));
}

TEST_F(GateTest, NamesTheWrongTokenFile) {
  for (const char* text : {"", "short\n", "0123456789abcdef and more\n"}) {
    write(text);
    EXPECT_THAT(refusal(), HasSubstr("server.web.token 'unity'")) << text;
    EXPECT_THAT(refusal(), HasSubstr("16 to 128")) << text;
  }
  write(kToken);
  EXPECT_EQ(refusal(), "no error");
}

}  // namespace
}  // namespace haptic::server
