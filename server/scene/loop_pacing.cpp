#include "server/scene/loop_pacing.hpp"

#include <string>

#include "haptic/core/error.hpp"
#include "server/base/figures.hpp"
#include "server/scene/problems.hpp"

namespace haptic::server {

void check_pacing(const LoopScene& loop, hw::Device& device) {
  const std::string field = "loop.paced_by = " + quoted(loop.paced_by) + ": ";
  if (device.sample_signal() == nullptr) {
    throw core::DeviceError(field + "this device has no clock of its own; must be a board");
  }
  const core::Duration period = device.info().limits.sample_period;
  if (period == loop.period) return;
  throw core::DeviceError(field + "this board takes a sample every " + milliseconds(period) +
                          "; must be loop.period, " + milliseconds(loop.period));
}

}  // namespace haptic::server
