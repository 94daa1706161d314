/// A MuJoCo simulation made haptic: a finger of two joints presses a soft ball and pushes a box, in
/// finger.xml beside this file, or in any model that has hinges "mcp" and "pip". Beside
/// `hapticd --scene finger_soft_grasp`.

#include "example.hpp"
#include "haptic/mujoco/tool.hpp"

namespace {

using namespace haptic;
constexpr double kRate = 60.0;  // Hz

int touch(client::Connection& server, const std::string& file, double seconds) {
  char error[500] = "";
  mjModel* model = mj_loadXML(file.c_str(), nullptr, error, sizeof error);
  if (model == nullptr) {
    std::fprintf(stderr, "%s: %s\n", file.c_str(), error);
    return 1;
  }
  mjData* data = mj_makeData(model);
  mujoco::Tool finger(model, data, {mujoco::joint("mcp", 0), mujoco::joint("pip", 1)},
                      {.coupling = 0.15});
  const auto session = server.open({.client_name = "MuJoCo finger",
                                    .nominal_rate_hz = kRate,
                                    .state_rate_hz = kRate,
                                    .reconnect = client::Reconnect::kWithBackoff,
                                    .re_engage = true,
                                    .on_disconnect = examples::print_end});
  session->engage_when_ready();
  for (int i = 1; examples::stop_requested == 0 && (seconds <= 0.0 || i <= seconds * kRate); ++i) {
    const client::DeviceState state = session->wait_for_state();
    const client::Proxy proxy = finger.step(state.x_probe, 1.0 / kRate, session->round_trip());
    session->publish(proxy);
    if (i % 60 != 0) continue;
    std::printf("%-9s %2zu contacts, actuator %6.2f N\n", client::name(state.state),
                proxy.planes.size(), state.tau_a.empty() ? 0.0 : state.tau_a[0]);
    std::fflush(stdout);
  }
  mj_deleteData(data);
  mj_deleteModel(model);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::string model;
  double seconds = 0.0;
  CLI::App cli("haptic-example-mujoco-finger - a finger in a MuJoCo simulation");
  cli.add_option("model", model, "an MJCF file, such as client/mujoco/examples/finger.xml")
      ->required();
  cli.add_option("--seconds", seconds, "stop after this long; 0: until interrupted");
  return examples::run(cli, argc, argv,
                       [&](client::Connection& server) { return touch(server, model, seconds); });
}
