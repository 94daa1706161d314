/// TLS and client certificates over real sockets; the certificates are made by openssl on the spot.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "haptic/core/error.hpp"
#include "server/front/grpc/peer_of.hpp"
#include "server/front/net/tls_files.hpp"
#include "tests/server/support/test_client.hpp"
#include "tests/support/file_text.hpp"
#include "tests/support/message_of.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::test {
namespace {

namespace fs = std::filesystem;

/// An issuer, a server's certificate for localhost, and two clients'.
class TlsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<ScratchFolder>();
    const TemporaryFile script(
        "set -e; cd '" + folder_->path().string() +
        "'; key='-newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes';"
        "openssl req -x509 $key -keyout ca.key -out ca.pem -subj /CN=issuer -days 2;"
        "openssl req -x509 $key -keyout other.key -out other.pem -subj /CN=other -days 2;"
        "for who in localhost surgeon student; do"
        "  openssl req $key -keyout $who.key -out $who.csr -subj /CN=$who;"
        "  echo subjectAltName=DNS:$who > $who.ext;"
        "  openssl x509 -req -in $who.csr -CA ca.pem -CAkey ca.key -CAcreateserial -days 2"
        "    -extfile $who.ext -out $who.pem;"
        "done");
    ASSERT_EQ(std::system(("sh '" + script.path().string() + "' >/dev/null 2>&1").c_str()), 0)
        << "openssl is needed (docker/install-deps.sh)";
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static fs::path file(const std::string& name) { return folder_->path() / name; }

  static server::TlsConfig tls(bool mutual) {
    server::TlsConfig config{.certificate = file("localhost.pem"), .key = file("localhost.key")};
    if (mutual) {
      config.client_ca = file("ca.pem");
      config.clients = {{"surgeon", server::Priority::kOperator},
                        {"student", server::Priority::kTest}};
    }
    return config;
  }
  static server::ServerScene config(bool mutual) {
    return {.listen = {"127.0.0.1:0"}, .udp_listen = "127.0.0.1:0", .tls = tls(mutual)};
  }
  static std::shared_ptr<grpc::Channel> channel(const LiveServer& server, const std::string& ca,
                                                const std::string& client = {}) {
    grpc::SslCredentialsOptions options;
    if (!ca.empty()) options.pem_root_certs = file_text(file(ca));
    if (!client.empty()) {
      options.pem_cert_chain = file_text(file(client + ".pem"));
      options.pem_private_key = file_text(file(client + ".key"));
    }
    grpc::ChannelArguments arguments;
    arguments.SetSslTargetNameOverride("localhost");
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    return grpc::CreateCustomChannel(server.address(), grpc::SslCredentials(options), arguments);
  }
  static grpc::Status info(const std::shared_ptr<grpc::Channel>& channel,
                           v1::GetServerInfoResponse* response) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + 20s);
    return v1::HapticService::NewStub(channel)->GetServerInfo(&context, {}, response);
  }
  static std::string load_error(const server::TlsConfig& config) {
    server::FrontConfig front;
    front.tls = config;
    return message_of<core::TransportError>(
        [&] { return server::read_tls(config, server::open_files(front, {})); });
  }

  static inline std::unique_ptr<ScratchFolder> folder_{};
};

TEST_F(TlsTest, ServesOnlyClientsTrustingTheIssuer) {
  LiveServer server(config(false));
  v1::GetServerInfoResponse response;
  ASSERT_TRUE(info(channel(server, "ca.pem"), &response).ok());
  ASSERT_EQ(server.rpc.served().size(), 1U);
  EXPECT_NE(server.rpc.served()[0].find("(TLS)"), std::string::npos);
  ASSERT_EQ(response.insecure_size(), 1);
  EXPECT_NE(response.insecure(0).find("without client certificates"), std::string::npos);
  EXPECT_EQ(info(channel(server, "other.pem"), &response).error_code(),
            grpc::StatusCode::UNAVAILABLE);
  EXPECT_EQ(info(server.channel(), &response).error_code(), grpc::StatusCode::UNAVAILABLE)
      << "plain text";
}

TEST_F(TlsTest, PriorityIsBoundByTheCertificate) {
  LiveServer server(config(true));
  v1::SessionRequest message = open_message(v1::ROLE_CONTROLLER, "student");
  message.mutable_open()->set_priority(v1::PRIORITY_PRIMARY);
  TestSession refused(channel(server, "ca.pem", "student"), message);
  EXPECT_EQ(refusal(refused.status()),
            (Refusal{grpc::StatusCode::PERMISSION_DENIED, "PRIORITY_DENIED"}));
  // Who asks for nothing has what the certificate allows: the surgeon takes it from the student.
  OpenSession student(channel(server, "ca.pem", "student"), v1::ROLE_CONTROLLER, "student");
  OpenSession surgeon(channel(server, "ca.pem", "surgeon"), v1::ROLE_CONTROLLER, "surgeon");
  EXPECT_EQ(server.rig.sessions->controller(), "surgeon");
}

TEST_F(TlsTest, PreemptionNeedsACertificate) {
  LiveServer server(config(false));
  OpenSession alice(channel(server, "ca.pem"));
  v1::SessionRequest message = open_message(v1::ROLE_CONTROLLER, "anybody");
  message.mutable_open()->set_priority(v1::PRIORITY_OPERATOR);
  TestSession refused(channel(server, "ca.pem"), message);
  EXPECT_EQ(refusal(refused.status()),
            (Refusal{grpc::StatusCode::PERMISSION_DENIED, "PRIORITY_DENIED"}));
  EXPECT_EQ(detail_of(refused.status(), "highest"), "primary");
  EXPECT_NE(refused.status().error_message().find("without a client certificate at most primary"),
            std::string::npos)
      << refused.status().error_message();
  EXPECT_EQ(server.rig.sessions->controller(), "alice");
}

TEST_F(TlsTest, NamesWrongFilesWithoutTheirContents) {
  server::TlsConfig config = tls(true);
  EXPECT_EQ(load_error(config), "no error");
  config.key = file("ca.key");
  std::string error = load_error(config);
  EXPECT_NE(error.find("server.tls.key"), std::string::npos);
  EXPECT_NE(error.find("must be that of the certificate"), std::string::npos);
  config.key = file("ca.pem");
  std::filesystem::permissions(config.key, std::filesystem::perms(0600));
  EXPECT_NE(load_error(config).find("must hold a private key"), std::string::npos);
  config = tls(true);
  config.certificate = file("localhost.key");
  error = load_error(config);
  EXPECT_NE(error.find("server.tls.certificate"), std::string::npos);
  EXPECT_EQ(error.find(file_text(file("localhost.key")).substr(40, 40)), std::string::npos);
  config = tls(true);
  config.client_ca = file("none.pem");
  EXPECT_NE(load_error(config).find("cannot be read"), std::string::npos);
}

TEST(Peer, KeysStayLocalOrInTls) {
  server::Peer peer;
  server::FrontConfig config;
  EXPECT_FALSE(may_have_keys(peer, config));
  peer.this_host = true;
  EXPECT_TRUE(may_have_keys(peer, config));
  peer.this_host = false;
  peer.encrypted = true;
  EXPECT_TRUE(may_have_keys(peer, config));
  peer.encrypted = false;
  config.insecure_lab = true;
  EXPECT_TRUE(may_have_keys(peer, config));
}

TEST(Peer, RecognisesThisHostByAddress) {
  for (const char* local : {"unix:", "unix:/run/h.sock", "ipv4:127.0.0.1:5", "ipv4:127.3.2.1:5",
                            "ipv6:[::1]:5", "ipv6:%5B::1%5D:5"}) {
    EXPECT_TRUE(server::is_this_host(local)) << local;
  }
  for (const char* far :
       {"", "ipv4:192.168.0.1:5", "ipv4:12.7.0.1:5", "ipv6:[fe80::1]:5", "ipv6:[::1:2]:5"}) {
    EXPECT_FALSE(server::is_this_host(far)) << far;
  }
}

TEST(Peer, WithoutCertificateOnlyLocalMayOperate) {
  server::FrontConfig config;
  server::Peer peer{.this_host = true};
  EXPECT_EQ(rights_of(peer, config).highest, server::Priority::kOperator);
  config.tls.emplace();
  EXPECT_EQ(rights_of(peer, config).highest, server::Priority::kOperator) << "a UNIX socket";
  peer.encrypted = true;
  EXPECT_EQ(rights_of(peer, config).highest, server::Priority::kPrimary);
}

TEST(Peer, HigherOfTwoNamesCounts) {
  server::FrontConfig config;
  config.tls.emplace();
  config.tls->clients = {{"a", server::Priority::kTest}, {"b", server::Priority::kOperator}};
  server::Peer peer{.names = {"a"}};
  EXPECT_EQ(rights_of(peer, config).highest, server::Priority::kTest);
  peer.names = {"a", "b"};
  EXPECT_EQ(rights_of(peer, config).highest, server::Priority::kOperator);
  peer.names = {"c"};
  EXPECT_EQ(rights_of(peer, config).highest, server::Priority::kPrimary);
}

}  // namespace
}  // namespace haptic::test
