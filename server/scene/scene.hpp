#pragma once
/// The scene as the rest of the server sees it: plain values, defaults filled
/// in, checked. Protobuf ends here.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic/core/tick/pipeline.hpp"
#include "haptic/wire/ports.hpp"
#include "hw/open_device.hpp"
#include "server/crossing/tls_config.hpp"
#include "server/scene/force_control.hpp"

namespace haptic::server {

struct DeviceScene {
  std::string name{};
  hw::DeviceConfig source{};
  std::shared_ptr<const core::Kinematics> kinematics{};
  core::ProjectionSettings projection{};
  core::RenderSettings settings{};  ///< the widest a session may ask for
  bool monotone_envelope{false};
  bool passivity_certificate{false};
  /// eps of the coupling metric that states carry (core/METHOD.md#anisotropic-coupling); absent:
  /// none.
  std::optional<double> coupling_softness{};
  core::PassivitySettings passivity{};
  std::vector<core::ActuatorRatings> ratings{};  ///< n_a, or none
  ForceControlScene force_control{};
  /// A client says where the palm is, and the scene's bound on its fresh_end.
  std::optional<core::TrackerSettings> tracker{};
  std::optional<core::Duration> tracker_fresh_end{};
  /// An upper bound on every session's fresh_end; absent: 2.5 nominal periods
  /// of the client.
  std::optional<core::Duration> fresh_end{};
};

/// What the scene says to the pipeline of a device with these limits; the loop's own settings keep
/// their defaults.
[[nodiscard]] core::PipelineConfig pipeline_config(const DeviceScene& scene,
                                                   const core::DeviceLimits& limits);

struct ServerScene {
  std::vector<std::string> listen{wire::kDefaultServer};
  std::string udp_listen{};      ///< empty: no UDP path
  std::string metrics_listen{};  ///< empty: no metrics
  core::Duration lease_timeout{std::chrono::seconds(2)};
  unsigned max_sessions{32};
  std::optional<TlsConfig> tls{};  ///< absent: plain text
};

struct LoopScene {
  core::Duration period{std::chrono::milliseconds(1)};
  /// Absent: 8 ms where real-time scheduling was granted, 20 ms elsewhere (
  /// proto/README.md#states-of-a-device).
  std::optional<core::Duration> loop_late_fault{};
  /// Level at which many small lags become a fault (proto/README.md#states-of-a-device).
  int late_bucket_full{core::LateBucket::kFull};
  int priority{80};
  std::optional<int> cpu{};
  std::string paced_by{};  ///< the board whose samples begin the ticks; empty: the timer
};

struct RecordScene {
  std::filesystem::path file{};
  bool compare_renderers{false};
};

struct Scene {
  std::string name{};
  std::vector<DeviceScene> devices{};
  ServerScene server{};
  LoopScene loop{};
  std::optional<RecordScene> record{};
  /// The scene as text with every default, as --print-scene shows it. Reads
  /// back as the same scene, from any folder: files stand with their full path.
  std::string resolved{};
  /// What may be served but deserves a word, each "field = value: why".
  std::vector<std::string> warnings{};
};

/// Where device number `device` of a scene with a record is recorded: `record.file` itself for an
/// only device, else with the device's name ("run.csv" -> "run-left.csv").
[[nodiscard]] std::filesystem::path record_file(const Scene& scene, std::size_t device);

/// Reads a scene. `overrides` are "path=value" as of --set, e.g.
/// "device[0].impedance.stiffness_n_per_m[0]=800". Throws SceneError with one
/// line for everything that is wrong: file, line, field, value and what is
/// allowed.
[[nodiscard]] Scene load_scene(const std::filesystem::path& file,
                               const std::vector<std::string>& overrides = {});
/// The same from text; `name` stands for the file in messages. Recordings that
/// are read are relative to `folder`; the file that is written (record.file) is
/// relative to the working directory.
[[nodiscard]] Scene parse_scene(const std::string& text, const std::string& name,
                                const std::filesystem::path& folder,
                                const std::vector<std::string>& overrides = {});

}  // namespace haptic::server
