#include "local_control.hpp"

#include <glob.h>
#include <ifaddrs.h>
#include <pwd.h>
#include <strings.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <sstream>
#include <string_view>

#include "haptic/wire/control_names.hpp"
#include "say.hpp"

namespace haptic::ctl {
namespace {

/// The user of the installed service (docker/packaging/debian/sysusers.conf).
constexpr char kServiceUser[] = "hapticd";

/// "dns:///robot:1", "ipv6:[fe80::1%25eth0]:1" as "robot:1", "[fe80::1%eth0]:1": gRPC's ways to
/// write an address.
std::string without_scheme(std::string server) {
  for (const std::string_view scheme : {"dns:", "ipv4:", "ipv6:"}) {
    if (!server.starts_with(scheme)) continue;
    server.erase(0, scheme.size());
    if (server.starts_with("//")) server.erase(0, std::min(server.find('/', 2), server.size()));
    if (server.starts_with("/")) server.erase(0, 1);
    server.resize(std::min(server.find(','), server.size()));  // the first of several
  }
  if (const std::size_t escaped = server.find("%25"); escaped != std::string::npos) {
    server.erase(escaped + 1, 2);
  }
  return server;
}

std::vector<std::string> addresses_of_this_host(const std::string& port) {
  std::vector<std::string> all;
  ifaddrs* first = nullptr;
  if (getifaddrs(&first) != 0) return all;
  for (const ifaddrs* each = first; each != nullptr; each = each->ifa_next) {
    const sockaddr* const address = each->ifa_addr;
    if (address == nullptr) continue;
    if (address->sa_family != AF_INET && address->sa_family != AF_INET6) continue;
    const std::string name = wire::endpoint_name(*address);
    all.push_back(name.substr(0, name.rfind(':')) + port);
  }
  freeifaddrs(first);
  return all;
}

bool is_name_of_this_host(const std::string& host) {
  char own[256]{};
  return gethostname(own, sizeof own - 1) == 0 && strcasecmp(own, host.c_str()) == 0;
}

/// Anybody may take a name that is free, and then answer as hapticd would.
bool trusted(uid_t holder) {
  if (holder == 0 || holder == geteuid()) return true;
  const passwd* const service = getpwnam(kServiceUser);
  return service != nullptr && holder == service->pw_uid;
}

/// Where a socket of one of the names may lie: in the folders that no stranger can change, then in
/// the abstract namespace, behind a zero byte.
std::vector<std::string> places(const std::vector<std::string>& names) {
  std::vector<std::string> folders{wire::kControlFolder};
  const char* const given = std::getenv("XDG_RUNTIME_DIR");
  folders.push_back((given != nullptr ? given : "/run/user/" + std::to_string(geteuid())) +
                    std::string(wire::kControlSubfolder));
  if (geteuid() == 0) {
    glob_t users{};
    const std::string all = std::string("/run/user/*") + wire::kControlSubfolder;
    if (glob(all.c_str(), GLOB_NOSORT, nullptr, &users) == 0) {
      folders.insert(folders.end(), users.gl_pathv, users.gl_pathv + users.gl_pathc);
    }
    globfree(&users);
  }
  std::vector<std::string> all;
  for (const std::string& folder : folders) {
    for (const std::string& name : names) {
      const std::string path = folder + "/" + wire::control_file(name);
      all.insert(all.end(), {path, path + wire::kForAll});
    }
  }
  for (const std::string& name : names) {
    all.push_back('\0' + std::string(wire::kAbstractPrefix) + wire::control_file(name));
  }
  return all;
}

/// A user may put a link into a folder of theirs, to the socket of another hapticd.
bool is_in_trusted_folder(const std::string& file) {
  struct stat folder {};
  const std::string path = file.substr(0, file.rfind('/'));
  return lstat(path.c_str(), &folder) == 0 && S_ISDIR(folder.st_mode) && trusted(folder.st_uid);
}

/// The whole answer, empty if none came. Absent: there is no socket, or it is not a hapticd's to be
/// believed, which is said.
std::optional<std::string> ask(const std::string& place, const std::string& command,
                               int patience_ms) {
  sockaddr_un address{};
  if (place.size() >= sizeof address.sun_path) return std::nullopt;
  const int socket = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (socket < 0) return std::nullopt;
  const timeval patience{patience_ms / 1000, patience_ms % 1000 * 1000};
  setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  address.sun_family = AF_UNIX;
  place.copy(address.sun_path, place.size());
  const bool abstract = place.front() == '\0';
  const auto length =
      static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + place.size() + (abstract ? 0 : 1));
  std::optional<std::string> answer;
  std::array<char, 65536> bytes{};
  ucred holder{};
  socklen_t holder_size = sizeof holder;
  if (connect(socket, reinterpret_cast<const sockaddr*>(&address), length) != 0 ||
      getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &holder, &holder_size) != 0) {
    // There is no socket of this name.
  } else if (!trusted(holder.uid)) {
    complain(
        "the control socket %s is not asked: it belongs to user %u, who is neither root, nor "
        "you, nor '%s'",
        abstract ? "@" + place.substr(1) : place, holder.uid, kServiceUser);
  } else if (!abstract && !is_in_trusted_folder(place)) {
    complain("the control socket %s is not asked: its folder belongs to another user", place);
  } else if (send(socket, command.data(), command.size(), MSG_NOSIGNAL) > 0) {
    const ssize_t got = recv(socket, bytes.data(), bytes.size(), 0);
    answer.emplace(bytes.data(), got > 0 ? static_cast<std::size_t>(got) : 0);
  }
  close(socket);
  return answer;
}

}  // namespace

std::vector<std::string> control_names_of(std::string server) {
  constexpr std::string_view kScene = "local:";
  if (server.starts_with(kScene)) return {server.substr(kScene.size())};
  if (server.starts_with("unix:")) return wire::control_names(server);
  server = without_scheme(std::move(server));
  const std::size_t colon = std::min(server.rfind(':'), server.size());
  const std::string host = server.substr(0, colon), port = server.substr(colon);
  const std::vector<std::string> own = addresses_of_this_host(port);
  // A resolver may keep an emergency stop waiting: this host's own name needs none.
  std::vector<std::string> names = is_name_of_this_host(host) ? own : wire::control_names(server);
  bool here = false;
  for (const std::string& name : names) {
    here = here || name.starts_with("127.") || name.starts_with("0.0.0.0:") ||
           name.starts_with("[::]:") || std::find(own.begin(), own.end(), name) != own.end();
  }
  if (!here) return names;
  const bool any = host == "0.0.0.0" || host == "[::]";
  if (any) names.insert(names.end(), own.begin(), own.end());
  names.insert(names.end(), {"0.0.0.0" + port, "[::]" + port});
  return names;
}

std::optional<std::vector<std::string>> ask_locally(const std::string& server,
                                                    const std::string& command,
                                                    std::string* refusal, int patience_ms) {
  std::optional<std::string> all;
  for (const std::string& place : places(control_names_of(server))) {
    if (!all) all = ask(place, command, patience_ms);
  }
  std::istringstream lines(all.value_or(""));
  std::string first;
  std::getline(lines, first);
  if (first != "ok") {
    if (refusal != nullptr) *refusal = first;
    return std::nullopt;
  }
  std::vector<std::string> rest;
  for (std::string line; std::getline(lines, line);) rest.push_back(line);
  return rest;
}

}  // namespace haptic::ctl
