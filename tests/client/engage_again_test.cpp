/// A second wish for force while the answer to the first is being handled.

#include <grpcpp/support/client_interceptor.h>

#include <atomic>

#include "client/src/remote_session.hpp"
#include "tests/client/support/fake_server.hpp"

namespace haptic::test {
namespace {

namespace experimental = grpc::experimental;
using std::chrono::milliseconds;

/// Runs an action on the thread that begins a Release, before the call leaves.
class BeforeRelease final : public experimental::Interceptor,
                            public experimental::ClientInterceptorFactoryInterface {
 public:
  explicit BeforeRelease(std::function<void()> action) : action_(std::move(action)) {}

 private:
  experimental::Interceptor* CreateClientInterceptor(experimental::ClientRpcInfo* call) override {
    const bool release = std::string(call->method()) == "/haptic.v1.HapticService/Release";
    return release ? new BeforeRelease(action_) : nullptr;  // gRPC deletes it
  }
  void Intercept(experimental::InterceptorBatchMethods* methods) override {
    using Point = experimental::InterceptionHookPoints;
    if (methods->QueryInterceptionHookPoint(Point::PRE_SEND_INITIAL_METADATA)) action_();
    methods->Proceed();
  }
  std::function<void()> action_;
};

/// The answer to an Engage that release() took back makes the client send Release. If the user asks
/// for force again just then, the next Engage waits until the first is done with: the session's
/// destructor waits for one call only.
TEST(EngageAgain, WaitsForTheFirstAnswer) {
  FakeServer server;
  std::atomic<bool> taken_back{false}, overlapped{false}, judged{false};
  client::RemoteSession* asking = nullptr;
  std::vector<std::unique_ptr<experimental::ClientInterceptorFactoryInterface>> interceptors;
  interceptors.push_back(std::make_unique<BeforeRelease>([&] {
    if (!taken_back.exchange(false)) return;
    asking->engage_when_ready();
    overlapped = server.until([&] { return server.heard().engages > 1; }, milliseconds(200));
    judged = true;
  }));
  client::SessionOptions options;
  options.on_state = [&](const client::DeviceState&) {
    asking->release();  // in a callback it does not wait for the Engage under way
    taken_back = true;
  };
  client::RemoteSession session(
      experimental::CreateCustomChannelWithInterceptors(
          server.address(), grpc::InsecureChannelCredentials(), {}, std::move(interceptors)),
      server.address(), options);
  asking = &session;
  session.open();
  server.hold_engage(true);
  session.engage_when_ready();
  ASSERT_TRUE(server.until([&] { return server.heard().engages == 1; }));
  server.send_state(1);
  ASSERT_TRUE(server.until([&] { return taken_back.load(); }));
  server.hold_engage(false);
  ASSERT_TRUE(server.until([&] { return judged.load(); }));
  EXPECT_FALSE(overlapped);
  EXPECT_TRUE(server.until([&] { return server.heard().engages == 2; }));
}

}  // namespace
}  // namespace haptic::test
