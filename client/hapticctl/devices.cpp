#include "commands.hpp"

namespace haptic::ctl {

client::Connection connect(const Options& options) {
  return options.tls ? client::Connection(options.server, options.tls_options)
                     : client::Connection(options.server);
}

std::vector<client::DeviceInfo> meant(client::Connection& server, const std::string& name) {
  std::vector<client::DeviceInfo> all = server.devices();
  if (name.empty()) return all;
  std::vector<std::string> names;
  for (const client::DeviceInfo& device : all) {
    if (device.name == name) return {device};
    names.push_back(device.name);
  }
  throw client::ClientError(client::ErrorReason::kNoSuchDevice,
                            "--device \"" + name + "\": must be one of " + joined(names));
}

std::string joined(const std::vector<std::string>& names) {
  if (names.empty()) return "none";
  std::string text = names.front();
  for (std::size_t i = 1; i < names.size(); ++i) text += ", " + names[i];
  return text;
}

std::string effort_unit(const std::string& unit) {
  return unit == "m" ? "N" : "N m";
}

}  // namespace haptic::ctl
