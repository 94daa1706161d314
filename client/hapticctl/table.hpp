#pragma once
/// A device's state as text: a table of rows for a terminal, one line for a log, JSON for scripts.

#include <string>
#include <vector>

#include "haptic/client/types.hpp"

namespace haptic::ctl {

using Rows = std::vector<std::string>;

/// `seconds` since the watching began.
[[nodiscard]] Rows table(const client::DeviceInfo& device, const client::DeviceState& state,
                         double seconds, std::uint64_t conflated);
[[nodiscard]] std::string line(const client::DeviceInfo& device, const client::DeviceState& state,
                               double seconds);
[[nodiscard]] std::string json_line(const client::DeviceInfo& device,
                                    const client::DeviceState& state, std::uint64_t conflated);
[[nodiscard]] std::string loop_row(const client::ServerInfo& server);

/// Rows on a terminal, each refresh over the one before.
class Screen {
 public:
  void show(const Rows& rows);

 private:
  std::size_t shown_{0};
};

}  // namespace haptic::ctl
