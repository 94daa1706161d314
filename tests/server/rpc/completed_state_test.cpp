// A hand in the loop is asked only for the fingers that something can hold; who listens, asks for the
// newest record or receives the state message finds all of them.
#include <gtest/gtest.h>

#include <chrono>

#include "hw/open_device.hpp"
#include "server/rpc/state_frame.hpp"
#include "server/scene/scene.hpp"
#include "server/telemetry/telemetry.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;

/// The shipped hand, and the ring between its loop and its listeners.
class CompletedState : public testing::Test, public server::RecordListener {
 public:
  CompletedState() : telemetry_({unit_.get()}) { telemetry_.add(0, this); }
  ~CompletedState() override { telemetry_.remove(0, this); }

 protected:
  void on_record(const core::TickRecord& record) override { heard_.push_back(record); }
  void on_newest(const core::TickRecord& record) override { newest_ = record; }

  void tick() {
    now_ += 1ms;
    unit_->tick(now_, 1ms, {});
  }
  /// A sample of the lease's client, with a stop on the index's PIP joint where it is `planes`.
  void sample(core::ProxyMode mode) {
    core::CommandSnapshot command;
    command.lease_epoch = 1;
    command.lease_held = true;
    unit_->commands.publish(command);
    core::ProxySnapshot proxy;
    proxy.mode = mode;
    proxy.epoch = 1;
    proxy.seq = ++seq_;
    proxy.born = now_;
    proxy.x = core::VecX::Constant(10, 0.4);
    if (mode == core::ProxyMode::kPlanes) {
      proxy.planes.normals = core::MatXQ::Zero(10, 1);
      proxy.planes.normals(3, 0) = 1.0;
      proxy.planes.offsets = core::VecX::Constant(1, 0.4);
    }
    unit_->proxies.publish(proxy);
  }
  [[nodiscard]] core::VecX f_of(const core::VecQ& q) const {
    core::VecX x;
    core::MatXQ J;
    EXPECT_EQ(device_.pipeline.kinematics->evaluate(q, x, J), core::MapStatus::kOk);
    return x;
  }

  server::Scene scene_ =
      server::load_scene(HAPTIC_SOURCE_DIR "/server/scenes/hand_five_fingers.textproto");
  const server::DeviceScene& device_ = scene_.devices.front();
  std::unique_ptr<server::DeviceUnit> unit_ = [this] {
    auto device = hw::open_device(*device_.source, device_.pipeline.kinematics);
    auto config = server::pipeline_config(device_, device->info().limits);
    return std::make_unique<server::DeviceUnit>("hand", std::move(device), std::move(config));
  }();
  server::Telemetry telemetry_;
  core::TimePoint now_{1h};
  std::uint64_t seq_{0};
  std::vector<core::TickRecord> heard_{};
  core::TickRecord newest_{};
};

TEST_F(CompletedState, WhoeverReadsARecordOutsideTheLoopFindsEveryFinger) {
  constexpr core::BlockSet kAll = 0b11111, kAllButIndex = 0b11101;
  for (const auto& [mode, open] :
       {std::pair{core::ProxyMode::kNone, kAll}, std::pair{core::ProxyMode::kFree, kAll},
        std::pair{core::ProxyMode::kPlanes, kAllButIndex},
        std::pair{core::ProxyMode::kHeld, core::BlockSet{0}}}) {
    if (mode != core::ProxyMode::kNone) sample(mode);
    heard_.clear();
    for (int i = 0; i < 3; ++i) tick();
    telemetry_.drain();
    ASSERT_EQ(heard_.size(), 3u);
    heard_.push_back(newest_);
    heard_.push_back(telemetry_.newest(0));
    for (const core::TickRecord& record : heard_) {
      ASSERT_EQ(record.unprobed, open) << "the tick did not ask for them";
      ASSERT_EQ(record.x_probe, f_of(record.q));
      if (mode == core::ProxyMode::kFree) {
        ASSERT_EQ(record.x, record.x_probe);
      }
      if (mode == core::ProxyMode::kPlanes) {
        EXPECT_EQ(record.x.head(2), record.x_probe.head(2));
        EXPECT_LE(record.x[3], 0.4 + 1e-12);
        EXPECT_LT(record.x[3], record.x_probe[3]);
        EXPECT_EQ(record.x.tail(6), record.x_probe.tail(6));
      }
    }
    server::StateFrame frame;
    frame.begin(newest_);
    const auto bytes = frame.for_datagram();
    v1::DeviceState state;
    ASSERT_TRUE(state.ParseFromArray(bytes.data(), static_cast<int>(bytes.size())));
    ASSERT_EQ(state.x_probe_size(), 10);
    const core::VecX told = f_of(newest_.q);
    for (int k = 0; k < 10; ++k) EXPECT_EQ(state.x_probe(k), told[k]);
    ASSERT_EQ(state.x_size(), mode == core::ProxyMode::kNone ? 0 : 10);
    for (const double x : state.x()) EXPECT_TRUE(std::isfinite(x));
  }
}

}  // namespace
}  // namespace haptic::test
