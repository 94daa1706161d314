// The servers that announce themselves on the local network, by the host's Avahi daemon.
#include <sys/wait.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

#include "commands.hpp"
#include "discovery/announced.hpp"
#include "say.hpp"

namespace haptic::ctl {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Announced, name, host, address, txt)
namespace {

using nlohmann::json;

// Any host of the network may announce as much as it likes.
constexpr std::size_t kMostServers = 256;
constexpr std::size_t kMostBytes = 1U << 20U;
constexpr double kLongestAnswer = 10.0;  // s; Avahi gives up on a silent host after 5 s

struct Found {
  std::set<Announced> servers{};
  bool more{false};  ///< it stopped at a bound
  int status{0};     ///< avahi-browse's, as wait() reports it
};

/// Without a time: until Avahi has named all that it knows of.
Found browse(double seconds) {
  char command[160];
  // The number is this program's; nothing of it comes from the network or a file.
  std::snprintf(command, sizeof command,
                "exec timeout --foreground --signal=KILL %.3f avahi-browse --resolve --parsable "
                "--no-db-lookup %s _hapticd._tcp",
                seconds > 0.0 ? seconds : kLongestAnswer, seconds > 0.0 ? "" : "--terminate");
  Found found;
  FILE* const lines = popen(command, "r");
  if (lines == nullptr) {
    found.status = -1;
    return found;
  }
  static std::array<char, 1U << 16U> line;
  std::size_t bytes = 0;
  while (std::fgets(line.data(), line.size(), lines) != nullptr) {
    std::string_view text(line.data());
    bytes += text.size();
    if (text.ends_with('\n')) text.remove_suffix(1);
    if (auto server = announced(text)) found.servers.insert(std::move(*server));
    found.more = bytes >= kMostBytes || found.servers.size() >= kMostServers;
    if (found.more) break;
  }
  found.status = pclose(lines);
  return found;
}

/// It listed all it knew, or its time is over.
bool worked(const Found& found) {
  constexpr int kTimeIsOver = 128 + SIGKILL;  // timeout's status after --signal=KILL
  const int status = WIFEXITED(found.status) ? WEXITSTATUS(found.status) : -1;
  return found.more || status == 0 || status == kTimeIsOver;
}

void print(const Announced& server) {
  say("%-28s %s at %s", server.address, dump(server.name), dump(server.host));
  for (const std::string& text : server.txt) say(" %s", dump(text));
  say("\n");
}

}  // namespace

int find(const Options& options) {
  const Found found = browse(options.seconds);
  if (!worked(found)) {
    complain("find needs avahi-browse (Debian's avahi-utils) and a running avahi-daemon");
    return kFailed;
  }
  if (options.json) {
    const json all{{"servers", found.servers}};
    say("%s\n", dump(all));
  } else {
    for (const Announced& server : found.servers) print(server);
  }
  if (found.more) {
    complain("more is announced than the %zu servers or %zu bytes shown", kMostServers, kMostBytes);
  }
  if (found.servers.empty()) {
    complain("no hapticd announces itself on this network");
    return kUnreachable;
  }
  return kDone;
}

}  // namespace haptic::ctl
