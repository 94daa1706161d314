#pragma once
/// A MuJoCo model of a test, and the simulation of it behind a network, in virtual time.

#include <mujoco/mujoco.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "haptic/client/planes.hpp"
#include "haptic/mujoco/tool.hpp"
#include "tests/support/loop/pipeline_loop.hpp"
#include "tests/support/plane_set.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::mujoco {

struct World {
  explicit World(const std::string& mjcf) {
    const test::TemporaryFile file(mjcf, "model.xml");
    load(file.path());
  }
  static World of_file(const std::string& path) {
    World world;
    world.load(path);
    return world;
  }

  [[nodiscard]] int id(int type, const char* name) const { return mj_name2id(m(), type, name); }
  /// Sum of the contacts' normal forces, by MuJoCo, N.
  [[nodiscard]] double force() const {
    double sum = 0.0;
    for (int i = 0; i < d()->ncon; ++i) {
      mjtNum one[6] = {};
      if (d()->contact[i].efc_address >= 0) mj_contactForce(m(), d(), i, one);
      sum += one[0];
    }
    return sum;
  }
  [[nodiscard]] mjModel* m() const { return model.get(); }
  [[nodiscard]] mjData* d() const { return data.get(); }

  std::unique_ptr<mjModel, decltype(&mj_deleteModel)> model{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, decltype(&mj_deleteData)> data{nullptr, mj_deleteData};

 private:
  World() = default;
  void load(const std::string& path) {
    mju_user_warning = [](const char*) {};  // MuJoCo would write a file
    char error[500] = "";
    model.reset(mj_loadXML(path.c_str(), nullptr, error, sizeof error));
    if (!model) throw std::runtime_error(error);
    data.reset(mj_makeData(model.get()));
  }
};

/// A round tool of 20 g and 10 mm that slides along x, and `objects`.
inline std::string slider_model(const std::string& objects, const std::string& option = "") {
  return R"(<mujoco><option timestep="0.001" gravity="0 0 0" )" + option + R"(/>
    <default><geom condim="1"/></default>
    <worldbody>
      <body name="tool"><joint name="x" type="slide" axis="1 0 0"/>
        <geom name="tip" type="sphere" size="0.01" mass="0.02"/></body>)" +
         objects + "</worldbody></mujoco>";
}

/// A wall that is touched at x = 20 mm, of 1500 N/m and 6 N s/m for that tool.
inline const std::string kSoftWall =
    R"(<geom name="wall" type="plane" pos="0.03 0 0" zaxis="-1 0 0" size="1 1 1"
             solref="-12500 -50" solimp="0.5 0.5 0.001"/>)";

/// A spring of a tool on that slide, N/m.
inline constexpr double kCoupling = 1500.0;

/// A model and its tool, which nothing but a test moves, at 60 samples/s.
struct Held {
  explicit Held(const std::string& mjcf, const std::vector<Binding>& bindings = {joint("x", 0)},
                const ToolOptions& options = {.coupling = kCoupling})
      : world(mjcf), tool(world.m(), world.d(), bindings, options) {}
  /// Returns the last of the samples.
  client::Proxy hold(const std::vector<double>& probe, int samples = 60, int delay_ms = 0) {
    client::Proxy proxy;
    for (int i = 0; i < samples; ++i) {
      proxy = tool.step(probe, 1.0 / 60.0, std::chrono::milliseconds(delay_ms));
    }
    return proxy;
  }
  [[nodiscard]] double force() const { return world.force(); }

  World world;
  Tool tool;
};

/// For how long a test holds an object: `usual` s, or HAPTIC_HOLD_S.
inline double hold_seconds(double usual) {
  const char* const wish = std::getenv("HAPTIC_HOLD_S");
  return wish != nullptr ? std::stod(wish) : usual;
}

/// The sample that the tool tells at every look, as the pipeline gets it.
inline test::ClientSettings told_by(Tool& tool, double rate_hz, double delay_s, int n_x) {
  test::ClientSettings client;
  client.mode = core::ProxyMode::kPlanes;
  client.stop = core::VecX::Constant(n_x, std::numeric_limits<double>::infinity());
  client.rate_hz = rate_hz;
  client.delay_s = delay_s;
  client.jitter = 0.0;
  client.simulate = [&tool, rate_hz, delay_s, n_x](test::Frame& frame) {
    const std::vector<double> probe(frame.x_probe.begin(), frame.x_probe.end());
    client::Proxy proxy = tool.step(
        probe, 1.0 / rate_hz, std::chrono::nanoseconds(static_cast<std::int64_t>(delay_s * 1e9)));
    client::keep_deepest(std::vector<client::VirtualCoordinate>(probe.size()), proxy.position,
                         probe, proxy.planes);
    frame.walls = test::plane_set(proxy.planes, n_x);
    frame.x = frame.x_probe;
    for (std::size_t i = 0; i < proxy.position.size(); ++i) {
      frame.x[static_cast<Eigen::Index>(i)] = proxy.position[i];
    }
    frame.contact = frame.anchored = !proxy.planes.empty();
  };
  return client;
}

}  // namespace haptic::mujoco
