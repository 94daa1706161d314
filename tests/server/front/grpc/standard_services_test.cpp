// Health, reflection and addresses, over real sockets. The stubs of the two standard services are
// not part of the distribution's headers, so their few bytes are written here by hand.
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>

#include <future>

#include "haptic/core/error.hpp"
#include "tests/server/support/test_client.hpp"

namespace haptic::test {
namespace {

std::string text(const grpc::ByteBuffer& buffer) {
  grpc::Slice slice;
  if (!buffer.DumpToSingleSlice(&slice).ok()) return {};
  return {reinterpret_cast<const char*>(slice.begin()), slice.size()};
}

grpc::ByteBuffer bytes(const std::string& content) {
  const grpc::Slice slice(content);
  return {&slice, 1};
}

/// grpc.health.v1.Health/Check: request {1: service}, response {1: status}. 1 SERVING, 2
/// NOT_SERVING; -1 where the service is not known.
int health(const std::shared_ptr<grpc::Channel>& channel, const std::string& service) {
  grpc::GenericStub stub(channel);
  grpc::ClientContext context;
  const grpc::ByteBuffer request = bytes(
      service.empty() ? "" : std::string("\x0a") + static_cast<char>(service.size()) + service);
  grpc::ByteBuffer response;
  std::promise<grpc::Status> done;
  stub.UnaryCall(&context, "/grpc.health.v1.Health/Check", {}, &request, &response,
                 [&](const grpc::Status& status) { done.set_value(status); });
  if (!done.get_future().get().ok()) return -1;
  const std::string answer = text(response);
  return answer.size() == 2 && answer[0] == '\x08' ? answer[1] : 0;
}

TEST(Health, ServesWhileTheLoopRuns) {
  LiveServer server;
  const auto channel = server.channel();
  EXPECT_TRUE(eventually([&] { return health(channel, "") == 1 && health(channel, "rig") == 1; }));
  EXPECT_EQ(health(channel, "nothing"), -1);
}

TEST(Health, IsNotServingWithoutTheDevice) {
  LiveServer server;
  const auto channel = server.channel();
  server.rig.device->lost = true;
  EXPECT_TRUE(eventually([&] { return health(channel, "") == 2 && health(channel, "rig") == 2; }));
}

TEST(Health, IsNotServingWhileLoopHangs) {
  LiveServer server;
  const auto channel = server.channel();
  ASSERT_TRUE(eventually([&] { return health(channel, "rig") == 1; }));
  server.hung = true;
  EXPECT_TRUE(eventually([&] { return health(channel, "rig") == 2; }));
  server.hung = false;
  EXPECT_TRUE(eventually([&] { return health(channel, "rig") == 1; }));
}

TEST(Health, AnEmergencyStopIsNoIllness) {
  LiveServer server;
  const auto channel = server.channel();
  server.rig.sessions->emergency_stop("", [](const Outcome<Done>&) {});
  ASSERT_TRUE(eventually([&] { return server.rig.newest().faults().any(); }));
  EXPECT_TRUE(eventually([&] { return health(channel, "rig") == 1; }));
}

/// One question to grpc.reflection.v1alpha.ServerReflection and its answer.
std::string reflect(const std::shared_ptr<grpc::Channel>& channel, const std::string& question) {
  grpc::GenericStub stub(channel);
  grpc::ClientContext context;
  grpc::CompletionQueue queue;
  const auto call = stub.PrepareCall(
      &context, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo", &queue);
  void* tag = nullptr;
  bool ok = false;
  const auto step = [&] { return queue.Next(&tag, &ok) && ok; };
  grpc::ByteBuffer answer;
  grpc::Status status;
  call->StartCall(nullptr);
  bool good = step();
  if (good) {
    call->Write(bytes(question), nullptr);
    good = step();
  }
  if (good) {
    call->Read(&answer, nullptr);
    good = step();
  }
  context.TryCancel();
  call->Finish(&status, nullptr);
  step();
  queue.Shutdown();
  while (queue.Next(&tag, &ok)) {
  }
  return good ? text(answer) : "";
}

TEST(Reflection, ListsOurServiceAndHealth) {
  LiveServer server;
  const std::string list = reflect(server.channel(), std::string("\x3a\x01*"));  // list_services
  EXPECT_NE(list.find("haptic.v1.HapticService"), std::string::npos);
  EXPECT_NE(list.find("grpc.health.v1.Health"), std::string::npos);
}

TEST(Reflection, KnowsTheServicesDescriptor) {
  LiveServer server;
  const std::string symbol = "haptic.v1.HapticService";
  const std::string question = std::string(1, '\x22') + static_cast<char>(symbol.size()) + symbol;
  const std::string answer = reflect(server.channel(), question);  // file_containing_symbol
  EXPECT_NE(answer.find("haptic/v1/haptic_service.proto"), std::string::npos);
  EXPECT_NE(answer.find("UpdateSettings"), std::string::npos);
}

std::string answer_of(const std::string& address) {
  try {
    const server::Listeners second({{address}}, false);
  } catch (const core::TransportError& error) {
    return error.what();
  }
  return "";
}

TEST(Address, NamesAPortInUse) {
  LiveServer server;
  const std::string error = answer_of(server.address());
  EXPECT_NE(error.find(server.address()), std::string::npos);
  EXPECT_NE(error.find("in use"), std::string::npos);
}

TEST(Address, UnixSocketStaysWithItsOwner) {
  const std::string address = "unix:/tmp/haptic_rpc_use_" + std::to_string(::getpid()) + ".sock";
  LiveServer server({{address}});
  EXPECT_NE(answer_of(address).find("in use"), std::string::npos);
  OpenSession session(server.channel(), v1::ROLE_OBSERVER, "still here");
}

TEST(Address, TakesOverAnAbandonedSocket) {
  const std::string address = "unix:/tmp/haptic_rpc_old_" + std::to_string(::getpid()) + ".sock";
  { LiveServer gone({{address}}); }
  LiveServer server({{address}});
  OpenSession session(server.channel(), v1::ROLE_OBSERVER, "new");
}

TEST(Address, PlaintextBeyondThisHostIsRefused) {
  EXPECT_NE(answer_of("0.0.0.0:0").find("TLS"), std::string::npos);
}

TEST(Address, SeveralAreServedAtOnce) {
  const std::string socket = "unix:/tmp/haptic_rpc_two_" + std::to_string(::getpid()) + ".sock";
  LiveServer server({{"127.0.0.1:0", socket}});
  for (const std::string& address : server.hand_over.addresses()) {
    OpenSession session(grpc::CreateChannel(address, grpc::InsecureChannelCredentials()),
                        v1::ROLE_OBSERVER, "both");
  }
}

}  // namespace
}  // namespace haptic::test
