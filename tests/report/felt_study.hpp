#pragma once
/// The finger in contact through a simulation that is slow or late, next to the same contact
/// through one that is neither: how far off is the torque that the finger feels
/// (tests/report/STUDY.md#felt-torque)? On the pipeline of a shipped scene, in virtual time.

#include <functional>
#include <string>
#include <vector>

#include "haptic/core/tick/pipeline.hpp"
#include "hw/motion/motion_csv.hpp"
#include "hw/simulated/finger_physics.hpp"
#include "tests/report/client_kind.hpp"
#include "tests/report/sensor_noise.hpp"
#include "tests/report/values.hpp"
#include "tests/support/loop/remote_client.hpp"

namespace haptic::report {

/// A worn finger as a shipped scene configures it; the renderer is chosen per run.
struct FeltDevice {
  core::PipelineConfig pipeline{};
  hw::FingerParameters finger{};
};
/// Pipeline of the scene that the demo runs, with this linkage. Throws SceneError: no such scene.
[[nodiscard]] FeltDevice felt_device(std::shared_ptr<const core::Kinematics> finger);

/// A recording of joint angles, shifted so that no joint is ever below 3 deg: where zero is was not
/// recorded exactly. Throws as hw::read_motion_csv does.
[[nodiscard]] hw::MotionTable flexed_recording(const std::string& file);

inline constexpr double kFeltSeconds = 1.5;  ///< of a motion

/// Aim of the hand, and the object in its way.
struct FeltTrajectory {
  int motion{0};         ///< its number: trajectories of one motion differ in the object
  bool recorded{false};  ///< else of the project's own making
  bool round{false};     ///< a disc in joint space; else one or two walls
  std::function<Eigen::Vector2d(double t_s)> aim{};  ///< rad, t in [0, kFeltSeconds]
  /// The object's planes, n_x by 1 or 2, nearest to a probe.
  std::function<core::PlaneSet(const core::VecX& x_probe)> object{};
  Eigen::Vector2d centre{Eigen::Vector2d::Zero()};  ///< of a disc, rad
};

struct FeltMotions {
  std::vector<FeltTrajectory> trajectories{};
  int recorded_motions{0}, made_motions{0};
  int left_out{
      0};  ///< windows of recordings: a gap, beyond the linkage's reach, or hardly a motion
};

/// `count` of them, two objects per motion: one flat, one round. First every window of
/// kFeltSeconds of the flexed recordings that `finger` reaches, then random reaches and returns.
[[nodiscard]] FeltMotions felt_motions(const core::Kinematics& finger,
                                       const std::vector<std::string>& recordings, int count,
                                       std::uint64_t seed);

/// A client that knows the object.
[[nodiscard]] test::ClientSettings client_of(const FeltTrajectory& what, ClientKind kind,
                                             const Network& network);

/// How a run is rendered and what is between it and its simulation.
struct FeltRun {
  core::RendererKind renderer{core::RendererKind::kSubspaceLinear};
  ClientKind client{ClientKind::kHeld};
  Network network{};
  SensorNoise noise{SensorNoise::kNone};  ///< of what is felt; the ideal has none
};

/// Sums over ticks, of torques at both joints squared, (N m)^2. Ideal: what a client that says in
/// every tick where the object's planes are, without delay, would make of the same pose, with the
/// same renderer and safeguards but no filters against noise. Best: of what the device can give
/// there, the nearest to the torque of a spring of Z_q at the actuator that pushes no contact in.
struct FeltSums {
  long ticks{0};       ///< of the motion
  long limited{0};     ///< of them: a limiter acted, here or on the ideal
  long throttled{0};   ///< of those: the energy tank
  long guarded{0};     ///< of those: the direction guard
  double error2{0.0};  ///< felt less ideal, in ticks without limiters
  double ideal2{0.0};  ///< ideal, in the same
  double over2{0.0};   ///< felt less best, in the same
  double best2{0.0};   ///< best, in the same
  double all2{0.0};    ///< felt less ideal, in every tick
  double ideal_all2{0.0};
  double band2{0.0};  ///< of the force felt less ideal between 50 and 500 Hz, N^2, times ticks
  int ended{0};       ///< runs in which force ended before the motion did

  FeltSums& operator+=(const FeltSums& other) noexcept;
};

/// The ticks of a run as the pipeline got them.
struct FeltInputs {
  struct Tick {
    core::TickInput input{};
    core::ProxySnapshot proxy{};
  };
  std::vector<Tick> before{};  ///< until the motion begins
  std::vector<Tick> motion{};
};

/// Throws SceneError where force never came on.
[[nodiscard]] FeltSums run(const FeltTrajectory& what, const FeltDevice& device,
                           const FeltRun& with, FeltInputs* inputs = nullptr);

/// CPU time in ns per tick of the motion, in a new pipeline that gets the same inputs.
[[nodiscard]] double replayed_tick_ns(const FeltDevice& device, core::RendererKind renderer,
                                      const FeltInputs& inputs);

}  // namespace haptic::report
