#include "haptic/mujoco/tool.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "aim.hpp"
#include "coupling.hpp"
#include "held_back.hpp"
#include "margins.hpp"
#include "near_contacts.hpp"
#include "taken_off.hpp"
#include "words.hpp"

namespace haptic::mujoco {

namespace {

using std::chrono::nanoseconds;

constexpr double kRise = 0.2;  // s, as the server's gain (proto/README.md, Staleness and gain)

mjData& forwarded(mjModel& model, mjData& data) {
  mj_forward(&model, &data);
  return data;
}

bool finite(const std::vector<double>& x) {
  return std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
}

/// Leaves `share` of the force that the contact has alone: of its spring in series with the
/// coupling, and of its object, which moves as before.
void soften(client::Plane& plane, double gives, double share) {
  plane.compliance = (plane.compliance + gives) / share - gives;
  for (double* part : {&plane.mass, &plane.damping, &plane.ground_stiffness, &plane.load}) {
    *part *= share;
  }
}

}  // namespace

struct Tool::State {
  State(mjModel* m, mjData* d, const std::vector<Binding>& bindings, const ToolOptions& o);
  /// The tool's aim is where the model has it.
  void restart();
  /// Restarts if the model is not where a step from the last pull() brought it: mj_resetData, a key
  /// of another time, a bad state after which MuJoCo began again, or steps without pull().
  void look_for_jump();
  void aim(const std::vector<double>& x_probe, int count, nanoseconds round_trip);
  void pull();
  [[nodiscard]] client::Proxy proxy();
  /// That MuJoCo found since the data began.
  [[nodiscard]] int bad_states() const {
    const mjWarningStat* const warning = data->warning;
    return warning[mjWARN_BADQPOS].number + warning[mjWARN_BADQVEL].number +
           warning[mjWARN_BADQACC].number;
  }

  mjModel* model;
  mjData* data;
  ToolOptions options;
  BoundTool tool;
  NearContacts contacts;
  Aim aimed;
  Coupling coupling;
  Margins margins;
  HeldBack held_back;
  std::vector<double> probe{};       ///< of the newest state, all coordinates
  std::vector<double> seen{};        ///< the tool as the last step began
  std::vector<mjtNum> rate{};        ///< qvel then
  bool known{false};                 ///< the last probe could be used
  double share{0.0};                 ///< of the force that is told, 0 to 1
  double last_time{0.0};             ///< as the last step began, s
  double last_step{0.0}, owed{0.0};  ///< s
  double room{1.0};                  ///< share of the horizon for which MuJoCo has room
  int times_full{0}, times_bad{0};
};

Tool::State::State(mjModel* m, mjData* d, const std::vector<Binding>& bindings,
                   const ToolOptions& o)
    : model(m),
      data(d),
      options(o),
      tool(*m, forwarded(*m, *d), bindings, o),
      contacts(tool),
      aimed(tool, options),
      coupling(*m, *d, tool, aimed, options),
      margins(*m, tool),
      held_back(tool, coupling, aimed) {
  take_off_limits(*model, tool);
  const std::string off = o.keep_actuators ? "" : take_off_actuators(*model, tool);
  if (!off.empty()) {
    warn("the device moves joints that have actuators in the model; these are off: " + off +
         " (keep_actuators leaves them on)");
  }
  restart();
}

void Tool::State::restart() {
  margins.grow(0.0);
  mj_forward(model, data);
  probe.assign(tool.coordinates(), 0.0);
  tool.look(*data);
  tool.read(*data, probe);
  seen = probe;
  aimed.begin(probe);
  held_back.restart();
  rate.assign(static_cast<std::size_t>(model->nv), 0.0);
  contacts.begin(*model, *data);
  last_time = data->time;
  last_step = model->opt.timestep;
  times_bad = bad_states();
  times_full = data->warning[mjWARN_CONTACTFULL].number;
}

void Tool::State::look_for_jump() {
  const double step = data->time - last_time;
  if (bad_states() == times_bad && step >= 0.0 && step < 1.5 * last_step) return;
  restart();
}

void Tool::State::aim(const std::vector<double>& x_probe, int count, nanoseconds round_trip) {
  if (count <= 0) throw std::invalid_argument("steps " + std::to_string(count) + ": must be > 0");
  look_for_jump();
  const double seconds = count * model->opt.timestep;
  // The probe may be deep inside an object as the tool arrives: from FREE force comes by a ramp.
  share = known && aimed.following() ? std::min(1.0, share + seconds / kRise) : 0.0;
  known = false;
  if (x_probe.empty() || !finite(x_probe)) return aimed.next({}, count, seconds);
  if (x_probe.size() < tool.coordinates()) {
    throw std::invalid_argument("x_probe has " + std::to_string(x_probe.size()) +
                                " coordinates, and coordinate " +
                                std::to_string(tool.coordinates() - 1) + " is bound");
  }
  if (!options.weights.empty() && options.weights.size() != x_probe.size()) {
    throw std::invalid_argument("x_probe has " + std::to_string(x_probe.size()) +
                                " coordinates, but there are " +
                                std::to_string(options.weights.size()) + " weights");
  }
  if (!tool.has_turns(x_probe)) return aimed.next({}, count, seconds);
  known = true;
  probe = x_probe;
  aimed.next(probe, count, seconds);
  const std::chrono::duration<double> period(seconds);
  // A list that is full has lost contacts, perhaps some that are touched.
  const int full = data->warning[mjWARN_CONTACTFULL].number;
  if (full > times_full) room *= 0.5;
  times_full = full;
  margins.grow(
      room * client::contact_horizon(round_trip, std::chrono::duration_cast<nanoseconds>(period)));
}

void Tool::State::pull() {
  look_for_jump();
  mj_kinematics(model, data);
  mj_comPos(model, data);
  seen = probe;
  tool.read(*data, seen);
  std::copy_n(data->qvel, model->nv, rate.begin());
  last_time = data->time;
  last_step = model->opt.timestep;
  aimed.step();
  coupling.pull(seen);
}

client::Proxy Tool::State::proxy() {
  look_for_jump();
  tool.look(*data);
  auto near = contacts.find(*model, *data, seen, rate);
  if (!known || !aimed.following() || share == 0.0) return client::Proxy::free();
  std::vector<double> x = probe, told(tool.coordinates());
  std::vector<client::Plane> planes;
  for (const NearContact& one : near) {
    client::Plane plane = client::contact_at(seen, one.contact, options.coupling);
    const bool moves = std::any_of(plane.normal.begin(), plane.normal.end(),
                                   [](double part) { return part != 0.0; });
    if (!moves) continue;
    double gives = 0.0;  // the square of the normal's length, in W^-1
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] -= share * plane.normal[i] * one.force / (coupling.stiffness(i));
      gives += plane.normal[i] * plane.normal[i] * options.coupling / coupling.stiffness(i);
      if (i < told.size()) told[i] += plane.normal[i] * one.force;
    }
    if (share < 1.0) soften(plane, gives, share);
    planes.push_back(std::move(plane));
  }
  if (share < 1.0) {
    held_back.restart();
  } else {
    held_back.look(*model, *data, std::move(told));
  }
  if (planes.empty()) return client::Proxy::free();
  // The half spaces as they were seen, with the normals by which x was displaced: joints and
  // friction keep the tool from x, and around x the object curves otherwise.
  return client::Proxy::behind(std::move(planes), std::move(x));
}

Tool::Tool(mjModel* model, mjData* data, const std::vector<Binding>& bindings,
           const ToolOptions& options)
    : state_(std::make_unique<State>(model, data, bindings, options)) {}
Tool::~Tool() = default;
Tool::Tool(Tool&&) noexcept = default;
Tool& Tool::operator=(Tool&&) noexcept = default;

void Tool::aim(const std::vector<double>& x_probe, int steps, nanoseconds round_trip) {
  state_->aim(x_probe, steps, round_trip);
}
void Tool::pull() {
  state_->pull();
}
client::Proxy Tool::proxy() {
  return state_->proxy();
}
void Tool::restart() {
  state_->restart();
}
bool Tool::following() const noexcept {
  return state_->aimed.following();
}
bool Tool::moves(int body) const {
  return state_->tool.moves(body);
}

client::Proxy Tool::step(const std::vector<double>& x_probe, double period,
                         nanoseconds round_trip) {
  State& s = *state_;
  s.owed += period;
  const int count = std::max(1, static_cast<int>(s.owed / s.model->opt.timestep + 1e-6));
  s.owed -= count * s.model->opt.timestep;
  aim(x_probe, count, round_trip);
  for (int i = 0; i < count; ++i) {
    pull();
    mj_step(s.model, s.data);
  }
  return proxy();
}

}  // namespace haptic::mujoco
