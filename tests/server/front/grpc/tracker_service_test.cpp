// The role tracker end to end: hapticd with its shipped scene on a real socket, a controller and a
// tracker, each with the client library's wire messages said by hand.
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include "tests/server/support/app.hpp"
#include "tests/server/support/test_client.hpp"

namespace haptic::test {
namespace {

server::Scene tracked(const char* name = "chain_on_tracked_palm") {
  server::Scene scene =
      server::load_scene(std::string(HAPTIC_SOURCE_DIR) + "/server/scenes/" + name + ".textproto");
  scene.server.listen = {"127.0.0.1:0"};
  // The effect of a busy machine on the loop, and on two streams, is another test's subject.
  scene.loop.loop_late_fault = 10s;
  for (server::DeviceScene& device : scene.devices) {
    device.pipeline.scene.staleness.hold_end = 5s;
    device.pipeline.scene.staleness.fade_end = 6s;
    if (device.pipeline.tracker) device.pipeline.tracker->staleness = {80ms, 1s, 1200ms};
  }
  return scene;
}

struct LiveApp {
  explicit LiveApp(server::Scene scene = tracked())
      : app(std::move(scene), {server::RealtimeMode::kOff}) {
    app.start();
    channel = grpc::CreateChannel(app.addresses().front(), grpc::InsecureChannelCredentials());
  }
  test::App app;
  std::shared_ptr<grpc::Channel> channel;
};

v1::SessionRequest tracker_opening(const std::string& name) {
  v1::SessionRequest message = open_message(v1::ROLE_TRACKER, name);
  message.mutable_open()->set_nominal_rate_hz(100.0);
  return message;
}

v1::SessionRequest pose(std::uint64_t seq, double x, double w = 1.0) {
  v1::SessionRequest message;
  v1::TrackerSample& sample = *message.mutable_tracker();
  sample.set_seq(seq);
  for (const double value : {x, 0.0, 0.0}) sample.add_position(value);
  for (const double value : {0.0, 0.0, 0.0, w}) sample.add_orientation(value);
  return message;
}

/// Says where the palm is, 100 times a second, until it is told to stop.
class Poses {
 public:
  Poses(TestSession& session, double x)
      : thread_([this, &session, x] {
          auto next = std::chrono::steady_clock::now();
          while (running_) {
            session.send(pose(++seq_, x));
            next = std::max(next + 10ms, std::chrono::steady_clock::now());
            std::this_thread::sleep_until(next);
          }
        }) {}
  ~Poses() { stop(); }
  void stop() {
    running_ = false;
    if (thread_.joinable()) thread_.join();
  }

 private:
  std::atomic<bool> running_{true};
  std::uint64_t seq_{0};
  std::thread thread_;
};

TEST(TrackerService, TrackersSilenceEndsTheForce) {
  LiveApp server;
  OpenSession tracker(server.channel, tracker_opening("camera"));
  EXPECT_EQ(tracker.opened().role(), v1::ROLE_TRACKER);
  EXPECT_EQ(tracker.opened().lease_epoch(), 0u);
  EXPECT_EQ(tracker.opened().fresh_end().nanos(), 25'000'000);  // 2.5 periods
  OpenSession controller(server.channel, v1::ROLE_CONTROLLER, "simulation");
  EXPECT_TRUE(eventually([&] { return controller.state().has_tracker(); }));
  EXPECT_EQ(controller.state().tracker().staleness(), v1::STALENESS_LEVEL_LOST) << "no pose so far";
  EXPECT_EQ(controller.state().tracker().seq_used(), 0u);
  Poses poses(tracker, 0.1);
  ASSERT_TRUE(eventually(
      [&] { return controller.state().q_size() == 8 && controller.state().q(0) == 0.1; }));
  EXPECT_EQ(controller.state().reading_size(), 0) << "nothing was refused";
  // The wrist's x is the palm's.
  EXPECT_DOUBLE_EQ(controller.state().x_probe(0), 0.1);
  EXPECT_EQ(server.app.owner().status(0).tracker, "camera");

  const v1::DeviceState at_rest = controller.state();
  ASSERT_TRUE(controller.press({at_rest.x_probe().begin(), at_rest.x_probe().end()}));
  poses.stop();
  EXPECT_TRUE(eventually([&] { return controller.heard(v1::Event::KIND_LOST); }));
  EXPECT_TRUE(
      eventually([&] { return controller.state().state() == v1::DEVICE_STATE_NAME_ARMED; }));
  const v1::DeviceState state = controller.state();
  EXPECT_EQ(state.gain(), 0.0);
  EXPECT_EQ(state.tracker().staleness(), v1::STALENESS_LEVEL_LOST);
  EXPECT_NE(state.staleness(), v1::STALENESS_LEVEL_LOST) << "the proxy's stream goes on";
  for (const v1::Event& event : controller.events()) {
    if (event.kind() != v1::Event::KIND_LOST) continue;
    EXPECT_EQ(event.reason(), "TRACKER_LOST");
  }
  EXPECT_EQ(reason_of(controller.engage()), "TRACKER_STALE");
}

TEST(TrackerService, AckNamesARefusedPose) {
  LiveApp server;
  OpenSession tracker(server.channel, tracker_opening("camera"));
  tracker.send(pose(1, 0.1));
  tracker.send(pose(2, 0.1, 0.5));
  EXPECT_TRUE(eventually([&] { return tracker.ack().rejected_invalid() == 1; }));
  EXPECT_EQ(tracker.ack().last_rejection(),
            "orientation has norm 0.5: must be a unit quaternion, within 0.01 of 1");
  tracker.send(pose(1, 0.1));
  EXPECT_TRUE(eventually([&] { return tracker.ack().rejected_old() == 1; }));
  EXPECT_EQ(tracker.ack().accepted(), 1u);
  EXPECT_EQ(reason_of(tracker.engage()), "NOT_CONTROLLER");

  OpenSession controller(server.channel, v1::ROLE_CONTROLLER, "simulation");
  controller.send(pose(1, 0.1));
  EXPECT_TRUE(eventually([&] { return controller.ack().rejected_old() == 1; }));
  EXPECT_EQ(controller.ack().last_rejection(),
            "this session is no tracker's: its poses are not used");
}

TEST(TrackerService, OnePerDeviceIfSceneAllows) {
  LiveApp server;
  OpenSession first(server.channel, tracker_opening("camera"));
  TestSession second(server.channel, tracker_opening("glove"));
  EXPECT_EQ(refusal(second.status()), (Refusal{grpc::StatusCode::ALREADY_EXISTS, "TRACKER_HELD"}));
  EXPECT_EQ(detail_of(second.status(), "holder"), "camera");
  first.cancel();
  EXPECT_TRUE(eventually([&] { return server.app.owner().status(0).tracker.empty(); }));
  OpenSession third(server.channel, tracker_opening("glove"));

  LiveApp untracked(tracked("chain_pick_arm"));
  TestSession refused(untracked.channel, tracker_opening("camera"));
  EXPECT_EQ(refused.status().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(field_of(refused.status()), "role");
}

}  // namespace
}  // namespace haptic::test
