/// A MuJoCo simulation made haptic without a line of code for it: whatever of the model has the
/// name of one of the device's coordinates follows the device (by_name in binding.hpp). finger.xml
/// next to this file is for `hapticd --scene finger_soft_grasp`, hand.xml for `hapticd --scene
/// hand_soft_grasp`; or a model of yours.

#include <algorithm>
#include <ctime>
#include <memory>
#include <stdexcept>

#include "example.hpp"
#include "film.hpp"
#include "haptic/mujoco/tool.hpp"

namespace {

using namespace haptic;
constexpr double kRate = 60.0;           // Hz
constexpr std::size_t kLongest = 36000;  // frames of a film: 10 minutes

struct Options {
  std::string model{};
  std::vector<std::string> joints{};
  double seconds{0.0}, coupling{0.0};
  bool keep_actuators{false};
  examples::FilmOptions film{};
};

using Model = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;
using Data = std::unique_ptr<mjData, decltype(&mj_deleteData)>;

Model load(const std::string& file) {
  char error[500] = "";
  Model model(mj_loadXML(file.c_str(), nullptr, error, sizeof error), mj_deleteModel);
  if (!model) throw std::runtime_error(file + ": " + error);
  return model;
}

/// The number in the model's <custom><numeric name="coupling" data="..."/></custom>; 0: none.
double coupling_of(const mjModel& model) {
  const int id = mj_name2id(&model, mjOBJ_NUMERIC, "coupling");
  return id < 0 ? 0.0 : model.numeric_data[model.numeric_adr[id]];
}

int touch(client::Connection& server, const Options& options) {
  const Model model = load(options.model);
  const Data data(mj_makeData(model.get()), mj_deleteData);
  const auto session = server.open({.client_name = "MuJoCo",
                                    .nominal_rate_hz = kRate,
                                    .state_rate_hz = kRate,
                                    .reconnect = client::Reconnect::kWithBackoff,
                                    .re_engage = true,
                                    .on_disconnect = examples::print_end});
  const std::vector<mujoco::Binding> bindings =
      mujoco::by_name(*model, session->device().coordinates, options.joints);
  const mujoco::ToolOptions coupled{
      .coupling = options.coupling > 0.0 ? options.coupling : coupling_of(*model),
      .keep_actuators = options.keep_actuators};
  mujoco::Tool tool(model.get(), data.get(), bindings, coupled);
  session->engage_when_ready();
  std::vector<examples::FilmFrame> frames;
  std::size_t most = 0, steps = 0;
  const std::clock_t began = std::clock();
  for (int i = 1;
       examples::stop_requested == 0 && (options.seconds <= 0.0 || i <= options.seconds * kRate);
       ++i) {
    const client::DeviceState state = session->wait_for_state();
    session->publish(tool.step(state.x_probe, 1.0 / kRate, session->round_trip()));
    std::vector<examples::Touch> touched = examples::touches_of(*model, *data, tool);
    const std::size_t contacts = touched.size();
    most = std::max(most, contacts);
    ++steps;
    if (options.film.wanted() && frames.size() < kLongest && tool.following()) {
      frames.push_back({std::vector<mjtNum>(data->qpos, data->qpos + model->nq), state.x_probe,
                        state.tau_a, std::move(touched)});
    }
    if (i % 60 != 0) continue;
    std::printf("%-9s %2zu contacts, motors", client::name(state.state), contacts);
    for (const double force : state.tau_a) std::printf(" %6.2f", force);
    std::puts(" N");
    std::fflush(stdout);
  }
  const double cpu = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
  const client::PublishStatistics samples = session->statistics();
  std::printf(
      "MuJoCo: %zu frames, %.0f %% of a core, at most %zu contacts at once; %llu samples "
      "accepted, %llu refused\n",
      steps, 100.0 * cpu * kRate / std::max<double>(1.0, static_cast<double>(steps)), most,
      static_cast<unsigned long long>(samples.accepted),
      static_cast<unsigned long long>(samples.rejected_invalid + samples.rejected_old));
  std::fflush(stdout);
  session->close();
  if (!frames.empty()) {
    examples::render(options.film, *load(options.model), bindings, coupled, session->device(),
                     frames);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App cli("haptic-example-mujoco - a MuJoCo simulation that a device moves");
  cli.add_option("model", options.model, "an MJCF file, such as client/mujoco/examples/finger.xml")
      ->required();
  cli.add_option("--seconds", options.seconds, "stop after this long; 0: until interrupted");
  cli.add_option("--coupling", options.coupling,
                 "N/m or N m/rad (ToolOptions); default: the model's numeric \"coupling\"");
  cli.add_option("--joint", options.joints,
                 "NAME=COORDINATE[,SCALE[,OFFSET]]: a joint with another name, sign or zero than "
                 "the device's coordinate, qpos = OFFSET + SCALE x; any number of them, several of "
                 "one coordinate too");
  cli.add_flag("--keep-actuators", options.keep_actuators,
               "the model's own actuators on joints that the device moves stay on");
  cli.add_option("--film", options.film.film, "a film of the run, .webm (by ffmpeg)");
  cli.add_option("--picture", options.film.picture, "a picture of its strongest grasp, .png");
  return examples::run(cli, argc, argv, [&](client::Connection& server) {
    try {
      return touch(server, options);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
      return 1;
    }
  });
}
