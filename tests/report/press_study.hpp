#pragma once
/// Random presses of a worn finger, on the real Pipeline in virtual time, and what the finger feels
/// of them against the best that the device can do (tests/report/STUDY.md#presses).

#include <functional>
#include <optional>
#include <vector>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "haptic/core/tick/pipeline.hpp"
#include "tests/report/client_kind.hpp"
#include "tests/report/sensor_noise.hpp"
#include "tests/report/values.hpp"

namespace haptic::report {

/// How the simulation sends its proxy: every tick without delay, or at 60 Hz and 20 ms late.
struct PressClient {
  std::string_view name;
  ClientKind kind;
  Network network;
};
inline constexpr std::array<PressClient, 4> kPressClients{
    {{"held", ClientKind::kHeld, {1000, 0.0}},
     {"held_late", ClientKind::kHeld, {60, 0.020}},
     {"planes", ClientKind::kPlanes, {1000, 0.0}},
     {"planes_late", ClientKind::kPlanes, {60, 0.020}}}};

enum class WallKind { kMcp, kPip, kBoth, kSlanted };
[[nodiscard]] inline std::string_view name(WallKind kind) noexcept {
  return name_in({"mcp", "pip", "both", "slanted"}, kind);
}

/// One press: the hand goes from its start to its aim and stays; walls n . x <= b are in the way.
struct RandomPress {
  int index{0};
  WallKind walls{WallKind::kMcp};
  core::PlaneSet planes{};  ///< unit normals, rad
  Pair start_deg{}, aim_deg{};
  double rise_s{0.8};        ///< of the way, minimum jerk
  double stiffness{1500.0};  ///< Z_q, N/m
  std::size_t client{0};     ///< of kPressClients
};

/// The same for the same seed and index, whatever else is drawn. `finger`: aim, start and walls are
/// within its reach.
[[nodiscard]] RandomPress random_press(std::uint64_t seed, int index,
                                       const core::Kinematics& finger);

/// The client with its number in kPressClients.
[[nodiscard]] test::ClientSettings client_of(const RandomPress& press);
/// Aim of its hand, `t` s after it leaves, rad.
[[nodiscard]] Eigen::Vector2d aim_of(const RandomPress& press, double t);

/// tank_0 in J of a finger's scene that names no tank (core/METHOD.md#safe-by-default): its engage
/// window is a quarter of 25 N.
[[nodiscard]] double default_tank(const RandomPress& press);

struct PressRun {
  core::RendererKind renderer{core::RendererKind::kSubspaceLinear};
  bool force{true};
  bool guard{true};
  std::optional<double> tank{};  ///< tank_0, J; absent: no tank
  SensorNoise noise{SensorNoise::kNone};
};

struct PressStudyTick {
  double t_s{0.0};
  Pair x_deg{};
  double depth_deg[2]{};  ///< beyond each wall, <= 0: outside
  double tau_a{0.0};      ///< N
  double optimum{0.0};    ///< N, of exact contacts without delay
  double away[2]{};       ///< n . W of each wall, m/rad: what 1 N does against it
  double given{0.0};      ///< J to the finger so far
  core::LimiterSet limiters{};
};

struct PressFigures {
  double end_deg[2]{};         ///< depth beyond each wall at the end
  double peak_deg[2]{};        ///< largest
  double end_force{0.0};       ///< N
  double peak_force{0.0};      ///< N, of the magnitude
  double band{0.0};            ///< N rms, 50 to 500 Hz, of the last 0.5 s
  double given{0.0};           ///< J, at the end
  double most_given{0.0};      ///< J, largest running sum
  double most_net{0.0};        ///< the same less what the device's own damping took
  int contact{0};              ///< ticks with a wall deeper than 0, force on
  int limited{0};              ///< of them: guard, tank, limits
  int throttled{0};            ///< ticks: tank
  int judged{0};               ///< contact ticks without limiters, deeper than kJudged
  int off{0};                  ///< of them: felt torque more than 10 % off the optimum
  int unrenderable{0};         ///< contact ticks in which the optimum is 0 or no wall has leverage
  double weakest{1.0};         ///< least |tau_a| over its running peak while depth grows
  double ripple{0.0};          ///< N rms of |change of tau_a| per tick in the last 0.3 s
  double throttled_step{0.0};  ///< N, largest change per tick where the tank throttles, in contact
  int pushed_in{0};            ///< ticks deeper than 0.25 deg in a wall that the force pushes into
};

/// Throws SceneError where force never came on.
[[nodiscard]] PressFigures run(const RandomPress& press, const PressRun& with,
                               const std::shared_ptr<const core::Kinematics>& finger,
                               const std::function<void(const PressStudyTick&)>& observe = {});

}  // namespace haptic::report
