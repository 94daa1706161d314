#pragma once
/// Random presses, and motions into objects and back, judged by what a hand notices: vibration,
/// steps, limiters that come and go, and what the safeguards cost (tests/report/STUDY.md#feel). On
/// the pipeline of a shipped scene, in virtual time, behind sensors with noise.
///
/// Next to the felt pipeline, and on its readings, run two more: one without tank and observer, and
/// one that renders Eq. (8) without the direction guard as well. So a step of the force has three
/// parts: what the tank adds to the same motion's without it, what guard or rule per contact add to
/// that, and the rest. To the pose itself, without noise, filters for it and tank, answer the same
/// client and the ideal one, which sends planes in every tick.

#include <array>
#include <functional>
#include <string_view>
#include <vector>

#include "tests/report/felt_study.hpp"
#include "tests/report/press_study.hpp"
#include "tests/report/sensor_noise.hpp"

namespace haptic::report {

/// Origin of a step of the force. Onset: a contact begins or ends, as the pipeline knows it.
/// Sample: a sample came. Motion: none of these.
enum class FeelCause { kTank, kGuard, kBand, kOnset, kSample, kMotion };
inline constexpr std::size_t kFeelCauses = 6;
[[nodiscard]] inline std::string_view name(FeelCause cause) noexcept {
  return name_in({"tank", "guard", "band", "onset", "sample", "motion"}, cause);
}

/// Friction and cogging of a drive, as the linkage feels them.
struct FeelDrive {
  double friction{0.0};  ///< N, Coulomb
  double cogging{0.0};   ///< N, amplitude over l_x
};
inline constexpr FeelDrive kRoughDrive{1.0, 0.5};  ///< chosen
inline constexpr double kCogging_m = 1e-3;         ///< period, chosen

/// The hand's way, the object, and the client that simulates it.
struct FeelTask {
  int index{0};
  bool press{false};  ///< else a motion
  std::string_view walls{}, client{};
  double seconds{0.0};
  std::function<Eigen::Vector2d(double t_s)> aim{};  ///< rad, t from 0
  test::ClientSettings remote{}, ideal{};
};
/// The press at its own start and aim.
[[nodiscard]] FeelTask feel_task(const RandomPress& press);
/// The motion, with one of kPressClients.
[[nodiscard]] FeelTask feel_task(const FeltTrajectory& motion, int index);

struct FeelRun {
  SensorNoise noise{SensorNoise::kNone};
  FeelDrive drive{};
  bool tank{true};
};

/// Rms between 50 and 500 Hz. Weighted: the predicted way of the fingertip by the threshold.
struct Vibration {
  double actuator{0.0};  ///< N
  double tip{0.0};       ///< N, of the torque at the PIP joint by 25 mm, a middle phalanx
  double weighted{0.0};  ///< < 1: below the published threshold
};

struct FeelFigures {
  Vibration felt{};                        ///< press: its last 0.5 s; motion: while in contact
  Vibration untanked{};                    ///< the same force without the tank's part
  std::array<double, kFeelCauses> step{};  ///< largest, N per ms
  int contact{0}, throttled{0};            ///< ticks
  int rough{0};                            ///< of the throttled: tank's step above kFeltStep
  int toggles{0};                          ///< of guard, rule per contact and tank, in contact
  double net{0.0};                         ///< J, most that was given, net of the device's damping
  double given{0.0};                       ///< J, most that was given
  double tank_0{0.0};                      ///< J
  double force{0.0};                       ///< N s, of the magnitude
  /// Sums over the ticks of torques squared at both joints, (N m)^2: felt less the ideal at the
  /// stiffness in effect, that ideal, felt less the same client's without noise, filters and tank,
  /// and the latter.
  double error2{0.0}, ideal2{0.0}, added2{0.0}, clean2{0.0};
  bool ended{false};  ///< force ended early

  [[nodiscard]] double guard_step() const noexcept;  ///< the larger one of guard and band, N per ms
};
inline constexpr double kFeltStep = 0.15;  ///< N per ms

struct FeelTick {
  double t_s{0.0}, tau{0.0}, untanked{0.0}, plain{0.0}, clean{0.0}, ideal{0.0};  ///< N
  Eigen::Vector2d x{Eigen::Vector2d::Zero()};                                    ///< rad
  core::LimiterSet limiters{};
};

/// `device`: its renderer, stiffness and damping are used. Throws SceneError where force never came
/// on.
[[nodiscard]] FeelFigures run(const FeelTask& task, const FeltDevice& device, const FeelRun& with,
                              const std::function<void(const FeelTick&)>& observe = {});

}  // namespace haptic::report
