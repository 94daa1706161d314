#include "tests/server/support/app.hpp"
#include "hw/simulated/hand.hpp"

#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <string>
#include <utility>

#include "haptic/core/error.hpp"
#include "server/base/version.hpp"
#include "tests/server/support/live_server.hpp"
#include "tests/server/support/test_client.hpp"
#include "tests/support/temporary_file.hpp"

namespace {

using namespace std::chrono_literals;
using haptic::server::load_scene;
using haptic::server::RealtimeMode;
using haptic::server::Scene;
using haptic::test::App;
using haptic::test::eventually;
using testing::HasSubstr;

Scene soft_grasp() {
  Scene scene =
      load_scene(std::string(HAPTIC_SOURCE_DIR) + "/server/scenes/finger_soft_grasp.textproto");
  scene.server.listen = {"127.0.0.1:0"};
  // A machine that builds at the same time is late at times; that is another test's subject.
  scene.loop.loop_late_fault = 10s;
  return scene;
}

/// Without memory locking, which is the process's and would outlive a test.
constexpr haptic::server::AppOptions kPlain{RealtimeMode::kOff};

TEST(App, StopsInTimeWithAWatcher) {
  App app(soft_grasp(), kPlain);
  app.start();
  ASSERT_EQ(app.addresses().size(), 1u);
  EXPECT_THAT(app.addresses().front(), HasSubstr("127.0.0.1:"));
  EXPECT_THAT(app.addresses().front(), testing::Not(testing::EndsWith(":0")));
  EXPECT_TRUE(eventually([&] { return app.loop_facts().ticks > 100; }));
  EXPECT_TRUE(eventually(
      [&] { return app.owner().status(0).state == haptic::core::LifecycleState::kIdle; }));

  const auto stub = haptic::v1::HapticService::NewStub(
      grpc::CreateChannel(app.addresses().front(), grpc::InsecureChannelCredentials()));
  haptic::v1::GetServerInfoResponse info;
  grpc::ClientContext asking, watching;
  ASSERT_TRUE(stub->GetServerInfo(&asking, {}, &info).ok());
  EXPECT_EQ(info.realtime().grade(), "best-effort");
  EXPECT_EQ(info.version(), haptic::server::version());
  const auto reader = stub->Watch(&watching, {});
  haptic::v1::WatchResponse response;
  ASSERT_TRUE(reader->Read(&response));

  const auto begin = std::chrono::steady_clock::now();
  app.stop();
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);
  EXPECT_TRUE(app.addresses().empty());
  while (reader->Read(&response)) {
  }
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  app.stop();  // idempotent
}

TEST(App, UnopenableDeviceLeavesNothingRunning) {
  Scene scene = soft_grasp();
  haptic::hw::SimulatedHandConfig hand;
  hand.motion_file = "no/such/motion.csv";
  scene.devices[0].source = std::make_shared<const haptic::hw::SimulatedHandConfig>(hand);
  App app(std::move(scene), kPlain);
  EXPECT_THROW(app.start(), haptic::core::DeviceError);
  EXPECT_TRUE(app.addresses().empty());
}

TEST(App, RecordsEveryTickIfAsked) {
  const haptic::test::TemporaryFile file;
  Scene scene = soft_grasp();
  scene.record = haptic::server::RecordScene{file.path(), true, true};
  std::uint64_t ticks = 0;
  {
    App app(std::move(scene), kPlain);
    app.start();
    EXPECT_TRUE(eventually([&] { return app.loop_facts().ticks > 50; }));
    ticks = app.loop_facts().ticks;
  }
  std::ifstream stream(file.path());
  std::uint64_t lines = 0;
  for (std::string line; std::getline(stream, line);) ++lines;
  EXPECT_GE(lines, ticks + 1);
}

// The grant of this host, whatever it is, decides the loop's patience
// (proto/README.md#staleness-and-gain). In a process of its own would be cleaner, but memory is
// locked as it is touched: the tests that follow do not notice.
TEST(App, LateFaultFollowsTheGrant) {
  Scene scene = soft_grasp();
  scene.loop.loop_late_fault.reset();
  App app(std::move(scene), {RealtimeMode::kTry});
  app.start();
  const bool fifo = app.realtime().facts.sched_fifo;
  EXPECT_EQ(app.unit(0).config().loop_late_fault, fifo ? 8ms : 20ms);
  EXPECT_FALSE(app.realtime().facts.explanation.empty());
}

}  // namespace
