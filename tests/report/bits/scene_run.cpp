#include "tests/report/bits/scene_run.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "haptic/core/error.hpp"
#include "hw/board/board_device.hpp"
#include "server/owner/scene/scene.hpp"
#include "tests/support/virtual_board.hpp"

namespace haptic::report {
namespace {

namespace fs = std::filesystem;
using core::LifecycleState;
using std::chrono::milliseconds;

constexpr int kEventsEvery = 100;      // ticks
constexpr int kFaultLasts = 60;        // ticks, until somebody clears it
constexpr int kAskForForceEvery = 10;  // ticks

/// The emulated board that a scene's board is, with a hand that goes to (30, 30) degrees.
std::unique_ptr<hw::Device> emulated(const hw::BoardConfig& board,
                                     const server::DeviceScene& scene) {
  using hw::emulator::BoardControl;
  hw::emulator::EmulatorConfig config;
  config.serial = board.serial.empty() ? config.serial : board.serial;
  if (scene.force_control == server::ForceControlPlace::kServer) {
    config.control = BoardControl::kDrive;
  } else if (scene.force_control == server::ForceControlPlace::kAdmittance) {
    config.control = BoardControl::kPosition;
  }
  const hw::HandIntent hand(Eigen::Vector2d(0.2, 0.2), Eigen::Vector2d(0.524, 0.524));
  return std::make_unique<hw::emulator::VirtualBoard>(config, hand, board,
                                                      scene.pipeline.kinematics);
}

std::unique_ptr<hw::Device> open(const server::DeviceScene& scene, core::Duration late) {
  const auto* const board = dynamic_cast<const hw::BoardConfig*>(scene.source.get());
  auto device = board != nullptr ? emulated(*board, scene)
                                 : scene.source->open(scene.pipeline.kinematics, late);
  server::check_force_control(scene.force_control, device->info());
  return device;
}

/// Limit of a host with real-time scheduling for a scene that does not say it.
core::Duration late_fault(const server::LoopScene& loop) {
  return loop.loop_late_fault.value_or(milliseconds(8));
}

core::PipelineConfig config_of(const server::DeviceScene& scene, const server::LoopScene& loop,
                               const hw::Device& device) {
  core::PipelineConfig config = server::pipeline_config(scene, device.info().limits);
  config.loop_late_fault = late_fault(loop);
  return config;
}

}  // namespace

SceneRun::SceneRun(const server::DeviceScene& scene, const server::LoopScene& loop,
                   std::uint64_t seed)
    : random_(seed, 0),
      device_(open(scene, late_fault(loop))),
      pipeline_(config_of(scene, loop, *device_)),
      client_(pipeline_.config(), seed),
      began_(std::chrono::hours(1)) {
  input_.now = began_;
  input_.period = loop.period;
  input_.settings = pipeline_.config().scene;
  input_.command.tenure = 1;
  input_.command.lease_held = true;
  client_.begin_lease(1, proxy_);
  command_.tau_a = core::VecA::Zero(pipeline_.config().kinematics->layout().n_a());
}

const core::TickRecord& SceneRun::tick() {
  ++ticks_;
  input_.now += input_.period;
  input_.loop = {};
  if (ticks_ % kEventsEvery == 0) act();
  if (record_.life.state == LifecycleState::kFault) {
    clear_faults();
  } else if (record_.life.state == LifecycleState::kArmed && ticks_ % kAskForForceEvery == 0) {
    ++input_.command.engage_id;
  }
  take_reading();
  if (pipeline_.config().tracker) take_pose();
  client_.step(record_, input_.now, proxy_);
  record_ = pipeline_.tick(input_, proxy_);
  command_.arm = record_.life.arm;
  command_.tau_a = record_.effort.drive.size() > 0 ? record_.effort.drive : record_.effort.tau_a;
  command_.position = record_.effort.position;
  device_->write(input_.now, command_);
  return record_;
}

/// Takes the device's reading, unless it is silent for a while, or says what is no number.
void SceneRun::take_reading() {
  reading_.fresh = false;
  device_->read(input_.now, reading_);
  if (silent_ticks_ > 0) {
    --silent_ticks_;
    input_.device.fresh = false;
    return;
  }
  input_.device = reading_;
  if (!input_.device.fresh) return;
  double& first = input_.device.sample.q[0];
  if (flip_) first = std::bit_cast<double>(std::bit_cast<std::uint64_t>(first) ^ 1U);
  flip_ = false;
  if (not_finite_) first = std::numeric_limits<double>::quiet_NaN();
  not_finite_ = false;
}

/// A tracker at 100 Hz on a palm that swings where the device says that it is, and pauses for
/// 300 ms in every 1.5 s.
void SceneRun::take_pose() {
  if (ticks_ % 10 != 0 || ticks_ % 1500 >= 1200 || reading_.sample.q.size() == 0) return;
  const core::TrackerSettings& tracker = *pipeline_.config().tracker;
  if (palm_at_first_.size() == 0) palm_at_first_ = reading_.sample.q.segment(tracker.first_dof, 6);
  const double t = std::chrono::duration<double>(input_.now - began_).count();
  core::TrackerSnapshot& pose = input_.tracker;
  ++pose.seq;
  pose.born = input_.now;
  pose.staleness = tracker.staleness;
  for (std::size_t i = 0; i < core::kPalmDofs; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double swing = 0.02 * std::sin((2.0 + static_cast<double>(i)) * t);
    pose.pose[i] = palm_at_first_[k] + swing;
  }
}

/// At most one event: the seeds make them all.
void SceneRun::act() {
  const double event = random_.uniform();
  core::CommandSnapshot& command = input_.command;
  if (event < 0.25) {
    change_settings();
  } else if (event < 0.40) {
    silent_ticks_ = 2 + static_cast<int>(random_.uniform() * 6.0);
  } else if (event < 0.43) {
    silent_ticks_ = 30;
  } else if (event < 0.53) {
    input_.loop = {milliseconds(2), 2};
    input_.now += milliseconds(2);
  } else if (event < 0.57) {
    ++command.release_id;
  } else if (event < 0.60) {
    ++command.stop_id;
  } else if (event < 0.62) {
    not_finite_ = true;
  } else if (event < 0.65) {
    client_.begin_lease(++command.tenure, proxy_);
  }
}

void SceneRun::clear_faults() {
  if (++faulty_ticks_ < kFaultLasts) return;
  faulty_ticks_ = 0;
  core::CommandSnapshot& command = input_.command;
  ++command.clear_id;
  command.clear = record_.faults();
  command.clear_stop_id = command.stop_id;
}

/// A session's change: less stiffness, damping and force; another renderer without force.
void SceneRun::change_settings() {
  const core::PipelineConfig& config = pipeline_.config();
  core::RenderSettings next = config.scene;
  next.id = input_.settings.id + 1;
  next.renderer = input_.settings.renderer;
  next.stiffness *= 0.4 + 0.6 * random_.uniform();
  next.damping *= random_.uniform();
  next.force_limit *= 0.3 + 0.7 * random_.uniform();
  next.slew_limit *= 0.3 + 0.7 * random_.uniform();
  next.direction_guard = next.direction_guard || random_.uniform() < 0.5;
  const bool no_force =
      record_.life.state == LifecycleState::kIdle || record_.life.state == LifecycleState::kArmed;
  const auto other = static_cast<std::size_t>(random_.uniform() * core::kRenderers.size());
  if (no_force && !(config.projection.coupling && !core::renders_Z_q(core::kRenderers[other]))) {
    next.renderer = core::kRenderers[other];
  }
  input_.settings = next;
}

namespace {

/// A scene's file that has devices and needs no other file than the scenes' own. The device of
/// `tls` is that of `offline`.
bool runs_alone(const fs::path& file) {
  return file.extension() == ".textproto" && file.stem().extension().empty() &&
         file.stem() != "tls";
}

}  // namespace

std::vector<ShippedDevice> shipped_devices(const fs::path& folder) {
  std::vector<ShippedDevice> all;
  for (const fs::path& where : {folder, folder / "fragments"}) {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(where)) {
      if (runs_alone(entry.path())) files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) {
      const server::Scene scene = server::load_scene(file);
      for (std::size_t i = 0; i < scene.devices.size(); ++i) {
        all.push_back({file.stem().string() + "/" + scene.devices[i].name, file, i});
      }
    }
  }
  return all;
}

SceneRun make_run(const ShippedDevice& which, std::uint64_t seed) {
  const server::Scene scene = server::load_scene(which.file);
  return {scene.devices.at(which.device), scene.loop, seed};
}

}  // namespace haptic::report
