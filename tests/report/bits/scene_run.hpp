#pragma once
/// A device of a shipped scene with its own simulated, recorded or emulated device, a client that
/// touches, and people and a network that are no help, in virtual time. The same seed gives the
/// same ticks.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "haptic/core/tick/pipeline.hpp"
#include "hw/device.hpp"
#include "tests/report/bits/touching_client.hpp"
#include "tests/support/link/random.hpp"

namespace haptic::server {
struct DeviceScene;
struct LoopScene;
}  // namespace haptic::server

namespace haptic::report {

class SceneRun {
 public:
  /// Throws SceneError or DeviceError if the scene cannot run in virtual time.
  SceneRun(const server::DeviceScene& scene, const server::LoopScene& loop, std::uint64_t seed);

  const core::TickRecord& tick();
  /// In the next tick the lowest bit of the first DoF's reading is the other one.
  void flip_a_bit() noexcept { flip_ = true; }

 private:
  void take_reading();
  void take_pose();
  void act();
  void clear_faults();
  void change_settings();

  haptic::test::Random random_;
  std::unique_ptr<hw::Device> device_;
  core::Pipeline pipeline_;
  TouchingClient client_;
  core::TickInput input_{};
  core::ProxySnapshot proxy_{};
  core::TickRecord record_{};
  hw::Command command_{};
  core::DeviceReading reading_{};  ///< as the device gave it
  core::VecQ palm_at_first_{};
  core::TimePoint began_{};
  int ticks_{0};
  int silent_ticks_{0}, faulty_ticks_{0};
  bool flip_{false};
  bool not_finite_{false};
};

/// A device of a scene's file.
struct ShippedDevice {
  std::string name{};  ///< "finger_constant/finger"
  std::filesystem::path file{};
  std::size_t device{0};
};
/// Every device of the scenes in `folder`, and of those in its folder "fragments".
[[nodiscard]] std::vector<ShippedDevice> shipped_devices(const std::filesystem::path& folder);
/// A run of one of them.
[[nodiscard]] SceneRun make_run(const ShippedDevice& which, std::uint64_t seed);

}  // namespace haptic::report
