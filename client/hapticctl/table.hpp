#pragma once
/// A device's state as text: a table for a terminal, one line for a log, JSON for scripts. Table
/// and JSON show every field that the protocol has.

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "haptic/client/types.hpp"

namespace haptic::ctl {

using Rows = std::vector<std::string>;

/// A row per field, longer ones in several of at most `width`. `seconds` since the watching began.
[[nodiscard]] Rows table(const client::DeviceInfo& device, const client::DeviceState& state,
                         double seconds, std::uint64_t conflated, std::size_t width);
/// A summary in one line.
[[nodiscard]] std::string line(const client::DeviceInfo& device, const client::DeviceState& state,
                               double seconds);
[[nodiscard]] nlohmann::json state_json(const client::DeviceInfo& device,
                                        const client::DeviceState& state);
/// Axis, labels and units of every field that state_json() gives by name alone.
[[nodiscard]] nlohmann::json json_fields(const client::DeviceInfo& device);
[[nodiscard]] std::string loop_row(const client::ServerInfo& server);

/// Rows on a terminal, each refresh over the one before.
class Screen {
 public:
  void show(const Rows& rows);
  /// Characters of a row.
  [[nodiscard]] static std::size_t width();

 private:
  std::size_t shown_{0};
};

}  // namespace haptic::ctl
