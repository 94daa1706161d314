#pragma once
/// The answer of the local control socket to `health`: what hapticd's owner knows, and what its
/// front claims (server/owner/local/local_health.hpp).

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace haptic::ctl {

struct FrontClaims {
  struct Device {
    std::string name{}, state{}, controller{};
    std::uint64_t sessions{0}, observers{0};
    std::uint64_t accepted{0}, accepted_per_s{0}, refused{0}, refused_per_s{0};  ///< samples
  };
  bool serves{false};
  std::uint64_t number{0}, process{0}, age_s{0};
  std::string why{};                     ///< why the last front ended, or could not serve
  std::vector<std::string> addresses{};  ///< that are served
  std::vector<Device> devices{};
  /// Open connections to the addresses by the kernel, which no front can forge; absent: it does not
  /// say.
  std::optional<std::uint64_t> connections{};

  /// A client is in control and its samples come, but the kernel knows no connection: the front
  /// plays the client.
  [[nodiscard]] bool front_plays_a_client() const;
};

/// `lines`: those after "ok". Without connections.
[[nodiscard]] FrontClaims front_claims(const std::vector<std::string>& lines);

/// Connections to `addresses` among the lines of /proc/net/tcp, tcp6 and unix.
[[nodiscard]] std::uint64_t count_connections(const std::vector<std::string>& addresses,
                                              const std::string& tcp, const std::string& local);

[[nodiscard]] std::string to_text(const FrontClaims& claims);
[[nodiscard]] nlohmann::json to_json(const FrontClaims& claims);

}  // namespace haptic::ctl
