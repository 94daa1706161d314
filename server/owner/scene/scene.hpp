#pragma once
/// A scene as the rest of the server sees it: plain values, defaults filled in, checked. No
/// protobuf type leaves server/owner/scene.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic/core/tick/pipeline.hpp"
#include "haptic/wire/ports.hpp"
#include "hw/device_config.hpp"
#include "server/crossing/tls_config.hpp"
#include "server/crossing/web_config.hpp"

namespace haptic::server {

/// Who closes the loop on the measured force; a device that cannot is refused when it opens.
enum class ForceControlPlace : std::uint8_t {
  kAny = 0,         ///< the scene does not say
  kBoard = 1,       ///< the device closes the loop itself
  kServer = 2,      ///< it measures force, takes forces, and does not close the loop itself
  kAdmittance = 3,  ///< it measures force and takes positions
};

struct DeviceScene {
  std::string name{};
  std::shared_ptr<const hw::DeviceConfig> source{};
  /// Complete but for `device` and `loop_late_fault`, which are known when the device is open.
  core::PipelineConfig pipeline{};
  ForceControlPlace force_control{ForceControlPlace::kAny};
  /// Upper bounds on fresh_end of the proxy and of the tracker's pose; absent: 2.5 nominal periods
  /// of the client.
  std::optional<core::Duration> fresh_end{}, tracker_fresh_end{};
};

/// The scene's pipeline for an opened device with these limits.
[[nodiscard]] core::PipelineConfig pipeline_config(const DeviceScene& scene,
                                                   const core::DeviceLimits& limits);

/// Empty if `address` has the form of one to serve; else what is allowed. Whether it can be served
/// is said when it is bound.
[[nodiscard]] std::string address_problem(const std::string& address);

struct ServerScene {
  std::vector<std::string> listen{wire::kDefaultServer};
  std::string udp_listen{};        ///< empty: no UDP path
  std::string metrics_listen{};    ///< empty: no metrics
  std::optional<WebConfig> web{};  ///< absent: no browsers
  core::Duration lease_timeout{std::chrono::seconds(2)};
  unsigned max_sessions{32};
  std::optional<TlsConfig> tls{};  ///< absent: plain text
  bool offline{false};             ///< no network: `listen` is empty
};

/// Defaults of a scene without hardware. A late tick of a simulated or replayed device can hurt no
/// one, and an ordinary laptop without real-time scheduling delays a thread by tens of milliseconds
/// now and then. Only what ends a session anyway, such as a suspend, is a fault: a lag of half the
/// default lease, or skipped ticks without end.
inline constexpr core::Duration kLateFaultWithoutHardware{std::chrono::seconds(1)};
inline constexpr int kLateBucketWithoutHardware = 1'000'000;

struct LoopScene {
  core::Duration period{std::chrono::milliseconds(1)};
  /// Absent: 8 ms if real-time scheduling is granted, else 20 ms
  /// (proto/README.md#states-of-a-device).
  std::optional<core::Duration> loop_late_fault{};
  int priority{80};
  std::optional<int> cpu{};
  std::string paced_by{};  ///< the device whose samples begin the ticks; empty: the timer
};

struct RecordScene {
  std::filesystem::path file{};
  bool compare_renderers{false};
  bool overwrite{false};
};

struct Scene {
  std::string name{};
  std::vector<DeviceScene> devices{};
  ServerScene server{};
  LoopScene loop{};
  std::optional<RecordScene> record{};
  /// The scene as text with every default, as --print-scene shows it. Reads back as the same scene
  /// from any folder: files have their full path.
  std::string resolved{};
  /// Warnings about what may be served but is questionable, each "field = value: why".
  std::vector<std::string> warnings{};
};

/// Where device number `device` of a scene with a record is recorded: `record.file` if it is the
/// only device, else with its name ("run.csv" -> "run-left.csv").
[[nodiscard]] std::filesystem::path record_file(const Scene& scene, std::size_t device);

/// Reads a scene. `overrides` are "path=value" as of --set (apply_override in text.hpp). Throws
/// SceneError with one line for everything that is wrong: file, line, field, value and what is
/// allowed.
[[nodiscard]] Scene load_scene(const std::filesystem::path& file,
                               const std::vector<std::string>& overrides = {});
/// The same from text; `name` stands for the file in messages. Files that are read are relative to
/// `folder`; the file that is written (record.file) is relative to the working directory.
[[nodiscard]] Scene parse_scene(const std::string& text, const std::string& name,
                                const std::filesystem::path& folder,
                                const std::vector<std::string>& overrides = {});

/// Throws DeviceError if the opened device cannot do what the scene's force_control needs.
void check_force_control(ForceControlPlace place, const hw::DeviceInfo& device);
/// Throws DeviceError if the opened device, which loop.paced_by names, cannot pace the loop: it has
/// no sample signal, or samples at another period than the loop's.
void check_pacing(const LoopScene& loop, hw::Device& device);

}  // namespace haptic::server
