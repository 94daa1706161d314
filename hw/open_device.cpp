#include "hw/open_device.hpp"

#include <utility>

#include "haptic/core/error.hpp"
#include "hw/board/board_device.hpp"
#include "hw/replay/replay.hpp"
#include "hw/simulated/finger.hpp"
#include "hw/simulated/linear.hpp"

namespace haptic::hw {
namespace {

using SharedKinematics = std::shared_ptr<const core::Kinematics>;

std::unique_ptr<Device> open(const SimulatedFingerConfig& config, SharedKinematics kinematics) {
  return std::make_unique<SimulatedFinger>(config, std::move(kinematics));
}

std::unique_ptr<Device> open(const SimulatedLinearConfig& config, SharedKinematics kinematics) {
  return std::make_unique<SimulatedLinear>(config, std::move(kinematics));
}

std::unique_ptr<Device> open(const ReplayConfig& config, SharedKinematics kinematics) {
  return std::make_unique<Replay>(config, std::move(kinematics));
}

std::unique_ptr<Device> open(const BoardConfig& config, const SharedKinematics& kinematics) {
  return std::make_unique<BoardDevice>(config, kinematics);
}

}  // namespace

std::unique_ptr<Device> open_device(const DeviceConfig& config, SharedKinematics kinematics) {
  if (!kinematics) throw core::DeviceError("a device cannot be opened without its kinematics");
  return std::visit([&](const auto& kind) { return open(kind, std::move(kinematics)); }, config);
}

}  // namespace haptic::hw
