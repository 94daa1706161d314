// The shipped soft grasp in virtual time, moved by its own motion and by recordings: the force
// grows with depth in every contact, as far as Eq. (31) and the tank let it.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <filesystem>

#include "client/examples/soft_finger.hpp"
#include "haptic/client/contact.hpp"
#include "haptic/client/planes.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "hw/simulated/hand.hpp"
#include "server/owner/scene/scene.hpp"
#include "tests/support/loop/remote_client.hpp"
#include "tests/support/plane_set.hpp"

namespace haptic::test {
namespace {

using std::chrono::milliseconds;
namespace fs = std::filesystem;
const fs::path kSource(HAPTIC_SOURCE_DIR);

/// `simulation` at 60 Hz, 2 ms away, as the example publishes it.
ClientSettings publisher(examples::SoftFinger& simulation) {
  ClientSettings client;
  client.mode = core::ProxyMode::kPlanes;
  client.delay_s = 0.002;
  client.simulate = [&simulation](Frame& frame) {
    const auto x = simulation.step({frame.x_probe[0], frame.x_probe[1]}).x;
    frame.x = Eigen::Vector2d(x[0], x[1]);
    auto planes = simulation.contacts(
        x, client::contact_horizon(milliseconds(2), std::chrono::microseconds(16667)));
    client::keep_deepest({{"mcp", "rad", "linear"}, {"pip", "rad", "linear"}}, {x[0], x[1]},
                         {frame.x_probe[0], frame.x_probe[1]}, planes);
    frame.walls = plane_set(planes, 2);
    frame.anchored = !planes.empty();
  };
  return client;
}

/// Ticks of all contacts of a run, each up to its deepest, in which the force stayed below 90 % of
/// its peak so far and of the best that the device can do there; and where it did so without the
/// tank.
struct Weak {
  int ticks{0}, weak{0}, without_tank{0};
};

Weak grasp(const fs::path& motion, int last_ms) {
  const server::DeviceScene scene =
      server::load_scene(kSource / "server/scenes/finger_soft_grasp.textproto").devices.at(0);
  auto source = dynamic_cast<const hw::SimulatedHandConfig&>(*scene.source);
  if (!motion.empty()) source.motion_file = motion;
  const auto device = source.open(scene.pipeline.kinematics, scene.pipeline.loop_late_fault);
  core::Pipeline pipeline(server::pipeline_config(scene, device->info().limits));
  examples::SoftFinger simulation, exact;
  RemoteClient client(publisher(simulation));
  core::TickInput in{.now = core::TimePoint(std::chrono::seconds(100))};
  in.settings = scene.pipeline.scene;
  core::ProxySnapshot newest;
  in.command.tenure = newest.tenure = 1;
  in.command.lease_held = true;
  hw::Command command{false, core::VecA::Zero(1), {}};
  Weak found;
  double deepest = 0.0, peak = 0.0;
  for (int ms = 1; ms <= last_ms; ++ms) {
    in.now += milliseconds(1);
    device->read(in.now, in.device);
    core::VecX x;
    core::MatXQ J;
    const core::VecQ q = in.device.sample.q;
    EXPECT_EQ(scene.pipeline.kinematics->evaluate(q, x, J), core::MapStatus::kOk);
    client.step(1e-3 * ms, in.now, q, x, newest);
    if (ms == 400) ++in.command.engage_id;
    const core::TickRecord record = pipeline.tick(in, newest);
    client.look_after(1e-3 * ms, record.sensed.q, record.anchor.x_probe);
    command.arm = record.life.arm;
    command.tau_a = record.effort.tau_a;
    device->write(in.now, command);
    const auto proxy = exact.step({x[0], x[1]});
    if (!proxy.touching) deepest = peak = 0.0;
    if (!proxy.touching || record.life.gain < 1.0) continue;
    const double felt = std::abs(record.effort.tau_a[0]);
    const Eigen::Vector2d dx(proxy.x[0] - x[0], proxy.x[1] - x[1]);
    const double best =
        std::abs(1500.0 * (Eigen::Matrix2d(J).inverse() * dx)[0]);  // Eq. (31) of Eq. (8)'s wish
    peak = std::max(peak, felt);
    const double depth = exact.depth({x[0], x[1]});
    if (depth <= deepest) continue;
    deepest = depth;
    ++found.ticks;
    if (felt >= 0.9 * std::min(peak, best) || peak < 0.2) continue;
    ++found.weak;
    found.without_tank += record.limiters().has(core::Limiter::kEnergyTank) ? 0 : 1;
  }
  return found;
}

TEST(SoftGrasp, ForceGrowsAsTheBestOne) {
  const Weak own = grasp({}, 20000);
  EXPECT_GT(own.ticks, 500);
  EXPECT_EQ(own.weak, 0);
  const fs::path data = kSource.parent_path() / "shared/data";
  if (!fs::exists(data)) GTEST_SKIP() << "the recordings of ../shared/data are not here";
  for (const char* file : {"dfki_pillow_grasps_100hz.csv", "leap_grab_115hz.csv"}) {
    EXPECT_EQ(grasp(data / file, 20000).weak, 0) << file;
  }
  // These pass through the object, which gives up to 127 mJ, and the tank holds their force back.
  for (const char* file : {"leap_dropouts_74hz.csv", "leap_fist_selfocclusion_110hz.csv"}) {
    const Weak found = grasp(data / file, 20000);
    EXPECT_GT(found.weak, 0) << file;
    EXPECT_EQ(found.without_tank, 0) << file;
  }
}

}  // namespace
}  // namespace haptic::test
