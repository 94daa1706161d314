#include "front_claims.hpp"

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "say.hpp"

namespace haptic::ctl {
namespace {

std::uint64_t number(const std::string& text) {
  return std::strtoull(text.c_str(), nullptr, 10);
}

/// Fields between tabs; `least` of them at least.
std::vector<std::string> fields(const std::string& line, std::size_t least) {
  std::vector<std::string> all;
  std::istringstream text(line);
  for (std::string field; std::getline(text, field, '\t');) all.push_back(field);
  all.resize(std::max(all.size(), least));
  return all;
}

}  // namespace

bool FrontClaims::front_plays_a_client() const {
  return connections && *connections == 0 &&
         std::any_of(devices.begin(), devices.end(),
                     [](const Device& device) { return device.accepted_per_s > 0; });
}

FrontClaims front_claims(const std::vector<std::string>& lines) {
  FrontClaims claims;
  for (const std::string& line : lines) {
    const std::vector<std::string> f = fields(line, 10);
    if (f[0] == "front") {
      claims.serves = f[1] == "serves";
      claims.number = number(f[2]);
      claims.process = number(f[3]);
      claims.age_s = number(f[4]);
      claims.why = f[5];
    } else if (f[0] == "address") {
      claims.addresses.push_back(f[1]);
    } else if (f[0] == "device") {
      claims.devices.push_back({f[1], f[2], f[9], number(f[3]), number(f[4]), number(f[5]),
                                number(f[6]), number(f[7]), number(f[8])});
    }
  }
  return claims;
}

std::uint64_t count_connections(const std::vector<std::string>& addresses, const std::string& tcp,
                                const std::string& local) {
  std::set<unsigned long> ports;
  std::set<std::string> paths;
  for (const std::string& address : addresses) {
    constexpr std::string_view kUnix = "unix:";
    if (address.starts_with(kUnix)) {
      const std::string path = address.substr(kUnix.size());
      paths.insert(path.starts_with("//") ? path.substr(2) : path);
    } else {
      ports.insert(std::strtoul(address.substr(address.rfind(':') + 1).c_str(), nullptr, 10));
    }
  }
  std::uint64_t found = 0;
  std::istringstream tcp_lines(tcp), unix_lines(local);
  for (std::string line; std::getline(tcp_lines, line);) {
    std::istringstream words(line);  // proc(5): slot, local address, remote address, state
    std::string slot, local, remote, state;
    words >> slot >> local >> remote >> state;
    const auto port = std::strtoul(local.substr(local.rfind(':') + 1).c_str(), nullptr, 16);
    if (state == "01" && ports.contains(port)) ++found;
  }
  for (std::string line; std::getline(unix_lines, line);) {
    std::istringstream words(line);  // number, references, protocol, flags, type, state, inode
    std::string skipped, state, inode, path;
    words >> skipped >> skipped >> skipped >> skipped >> skipped >> state >> inode >> path;
    if (state == "03" && paths.contains(path)) ++found;
  }
  return found;
}

std::string to_text(const FrontClaims& claims) {
  std::string all;
  if (claims.serves) {
    all = text("front %llu (process %llu) serves for %llu s",
               static_cast<unsigned long long>(claims.number),
               static_cast<unsigned long long>(claims.process),
               static_cast<unsigned long long>(claims.age_s));
  } else {
    all = "no front serves: nothing but this host's control socket answers";
  }
  if (claims.connections) all += "; " + std::to_string(*claims.connections) + " connections";
  if (!claims.serves && !claims.why.empty()) all += text("\n  %s", claims.why);
  for (const FrontClaims::Device& d : claims.devices) {
    all += text(
        "\n%s: %s, %llu sessions, %llu observers, controller %s; samples %llu/s accepted, "
        "%llu/s refused, %llu and %llu in all",
        d.name, d.state, static_cast<unsigned long long>(d.sessions),
        static_cast<unsigned long long>(d.observers),
        d.controller.empty() ? std::string("none") : "'" + d.controller + "'",
        static_cast<unsigned long long>(d.accepted_per_s),
        static_cast<unsigned long long>(d.refused_per_s),
        static_cast<unsigned long long>(d.accepted), static_cast<unsigned long long>(d.refused));
  }
  if (claims.front_plays_a_client()) {
    all +=
        "\nWARNING: samples come, and no client is connected: the front plays a client. Stop "
        "with hapticctl estop, then hapticctl restart-front";
  }
  return all;
}

nlohmann::json to_json(const FrontClaims& claims) {
  nlohmann::json devices = nlohmann::json::array();
  for (const FrontClaims::Device& d : claims.devices) {
    devices.push_back({{"name", d.name},
                       {"state", d.state},
                       {"sessions", d.sessions},
                       {"observers", d.observers},
                       {"controller", d.controller},
                       {"samples_accepted", d.accepted},
                       {"samples_accepted_per_s", d.accepted_per_s},
                       {"samples_refused", d.refused},
                       {"samples_refused_per_s", d.refused_per_s}});
  }
  nlohmann::json all{
      {"serves", claims.serves},   {"number", claims.number},
      {"process", claims.process}, {"age_s", claims.age_s},
      {"why", claims.why},         {"devices", devices},
      {"connections", nullptr},    {"plays_a_client", claims.front_plays_a_client()}};
  if (claims.connections) all["connections"] = *claims.connections;
  return all;
}

}  // namespace haptic::ctl
