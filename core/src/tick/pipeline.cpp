#include "haptic/core/tick/pipeline.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "actuation.hpp"
#include "clock.hpp"
#include "derating.hpp"
#include "haptic/core/error.hpp"
#include "proxy_intake.hpp"
#include "rendering.hpp"
#include "sensing.hpp"
#include "session_settings.hpp"
#include "supervisor.hpp"

namespace haptic::core {

namespace {

void require(bool holds, const std::string& what) {
  if (!holds) throw SceneError(what);
}

/// `wrong`: what a check() says, null if nothing.
void require_right(const char* wrong, const std::string& where) {
  if (wrong != nullptr) throw SceneError(where + ": " + wrong);
}

/// `highest`: as many as the values.
void require_entries(const VecA& values, int n_a, const char* name, double lowest,
                     const VecA* highest = nullptr) {
  require(values.size() == n_a, std::string(name) + " has " + std::to_string(values.size()) +
                                    " values: must have one per actuated DoF, " +
                                    std::to_string(n_a));
  for (int i = 0; i < n_a; ++i) {
    const std::string value = std::string(name) + "[" + std::to_string(i) +
                              "] = " + std::to_string(values[i]) + ": must be finite and ";
    require(std::isfinite(values[i]) && values[i] >= lowest,
            value + ">= " + std::to_string(lowest));
    if (highest == nullptr) continue;
    require(values[i] <= (*highest)[i], value + "<= " + std::to_string((*highest)[i]));
  }
}

void check_tracker(const TrackerSettings& tracker, const Kinematics& kinematics) {
  constexpr int kDofs = static_cast<int>(kPalmDofs);
  const int n_q = kinematics.layout().n_q();
  require(tracker.first_dof >= 0 && tracker.first_dof + kDofs <= n_q,
          "tracker.first_dof = " + std::to_string(tracker.first_dof) +
              ": must leave room for six of " + std::to_string(n_q) + " DoFs");
  for (int i = tracker.first_dof; i < tracker.first_dof + kDofs; ++i) {
    const DofSpec& dof = kinematics.dofs()[static_cast<std::size_t>(i)];
    require(!dof.actuated, "tracker: DoF " + dof.name + " is actuated: must be sensed only");
  }
  require_right(check(tracker.staleness), "tracker.staleness");
}

PipelineConfig checked(PipelineConfig config) {
  require(config.kinematics != nullptr, "kinematics: must be given");
  const int n_q = config.kinematics->layout().n_q();
  const int n_a = config.kinematics->layout().n_a();
  const DeviceLimits& device = config.device;
  require(device.q_lower.size() == n_q && device.q_upper.size() == n_q,
          "device range: must have one pair per DoF, " + std::to_string(n_q));
  require(device.sample_period > Duration::zero(), "device.sample_period: must be > 0");
  require(device.max_silence >= device.sample_period,
          "device.max_silence: must be >= its sample_period");
  require_entries(device.max_effort, n_a, "device.max_effort", 0.0);
  const SensorFilter& filter = config.filter;
  require(std::min({filter.sensed_lag, filter.actuated_lag, filter.rate_lag}) >= Duration::zero(),
          "filter: lags must be >= 0");

  const RenderSettings& scene = config.scene;
  require_entries(scene.stiffness, n_a, "stiffness", 0.0);
  require_entries(scene.damping, n_a, "damping", 0.0);
  require_entries(scene.force_limit, n_a, "force_limit", 0.0, &device.max_effort);
  require_entries(scene.slew_limit, n_a, "slew_limit", 0.0);
  require_entries(scene.engage_window, n_a, "engage_window", 0.0);
  require_right(check(scene.staleness), "staleness");
  require(
      config.projection.coupling == nullptr || renders_Z_q(scene.renderer),
      "renderer " + std::string(name(scene.renderer)) +
          ": must be a subspace method where the stiffness matrix is not diagonal; the others have "
          "a virtual stiffness of their own");
  require_right(check(config.passivity, n_a), "passivity");
  require(config.ratings.empty() || config.ratings.size() == static_cast<std::size_t>(n_a),
          "ratings: must have one per actuated DoF, " + std::to_string(n_a) + ", or none");
  for (std::size_t i = 0; i < config.ratings.size(); ++i) {
    require_right(check(config.ratings[i]), "ratings[" + std::to_string(i) + "]");
  }
  const std::vector<CellRatings>& cells = config.force_control.cells;
  require(cells.empty() ||
              (config.force_control.enabled() && cells.size() == static_cast<std::size_t>(n_a)),
          "force_control: load cells: must be one per actuated DoF, " + std::to_string(n_a) +
              ", with a force loop or an admittance, or none");
  for (const CellRatings& cell : cells) require_right(check(cell), "force_control: load cell");
  if (config.tracker) check_tracker(*config.tracker, *config.kinematics);
  require(config.loop_late_fault > Duration::zero(), "loop_late_fault: must be > 0");
  require(config.late_bucket_full > 0, "late_bucket_full: must be > 0");
  require_rank(ProjectionModel(*config.kinematics, config.projection));
  return config;
}

/// How long a contact that moves goes on as it was told: while force is whole, which the age of the
/// sample's arrival decides.
Duration contact_age(const ProxySnapshot& sample, TimePoint now,
                     const Settings& settings) noexcept {
  const Duration most = settings.staleness.hold_end;
  const TimePoint told = sample.computed == TimePoint{} ? sample.born : sample.computed;
  return std::clamp(sample.born - told, Duration::zero(), most) +
         std::clamp(now - sample.born, Duration::zero(), most);
}

}  // namespace

/// The stages in the order in which a tick takes them, and what a tick needs of the last one.
class Pipeline::Stages {
 public:
  explicit Stages(PipelineConfig config)
      : config_(std::move(config)),
        model_(*config_.kinematics, config_.projection),
        clock_(config_.loop_late_fault, config_.late_bucket_full),
        settings_(config_.scene, model_.coupling()),
        sensing_(config_),
        proxy_(model_.n_x()),
        derating_(config_, model_.coupling()),
        rendering_(model_, config_),
        supervisor_(model_.layout(), config_.device.sample_period),
        actuation_(model_, config_),
        in_use_(VecQ::Zero(model_.layout().n_q())) {}

  [[nodiscard]] TickRecord tick(const TickInput& in, const ProxySnapshot& newest) noexcept {
    const Settings& settings = settings_.step(in.settings, state_);
    // Each result is made in its place in the record, where the stages that follow read it.
    TickRecord now{
        .input = in,
        .beat = clock_.step(in, ready_),
        .settings_id = settings.id,
        .sensed = sensing_.step(in, now.beat.dt, driven_, derating_.lag()),
        .proxy = proxy_.step(in, newest, settings.staleness, now.sensed.tracker, state_),
        .derating =
            derating_.step(in, now.beat, now.sensed, proxy_.sample(), proxy_.moved(), settings),
        .anchor = rendering_.step(
            {now.beat.tick, seconds(contact_age(proxy_.sample(), in.now, settings)), in.now},
            now.sensed, proxy_.sample(), derating_.settings(settings), in_use_),
        .life = supervisor_.step(in, now.beat, settings, now.sensed, now.proxy, now.anchor,
                                 output_faults_),
        .effort =
            actuation_.step(now.beat, now.sensed, now.anchor, now.life,
                            derating_.settings(settings), rendering_.displacement(now.sensed)),
    };
    ready_ = now.sensed.ready;
    state_ = now.life.state;
    in_use_ = now.effort.q_star;
    output_faults_ = now.effort.faults;
    driven_.on = now.life.gain > 0.0 || now.life.damping_gain > 0.0;
    driven_.command = now.effort.drive.size() > 0 ? now.effort.drive : now.effort.position;
    return now;
  }
  [[nodiscard]] const PipelineConfig& config() const noexcept { return config_; }

 private:
  const PipelineConfig config_;
  const ProjectionModel model_;
  Clock clock_;
  SessionSettings settings_;
  Sensing sensing_;
  ProxyIntake proxy_;
  Derating derating_;
  Rendering rendering_;
  Supervisor supervisor_;
  Actuation actuation_;
  // State that the last tick left:
  bool ready_{false};
  LifecycleState state_{LifecycleState::kInit};
  VecQ in_use_;
  FaultSet output_faults_{};
  Driven driven_{};
};

Pipeline::Pipeline(PipelineConfig config)
    : stages_(std::make_unique<Stages>(checked(std::move(config)))) {}
Pipeline::~Pipeline() = default;
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;

TickRecord Pipeline::tick(const TickInput& input, const ProxySnapshot& newest) noexcept {
  return stages_->tick(input, newest);
}

const PipelineConfig& Pipeline::config() const noexcept {
  return stages_->config();
}

}  // namespace haptic::core
