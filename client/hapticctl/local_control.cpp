#include "local_control.hpp"

#include <pwd.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <sstream>
#include <string_view>

namespace haptic::ctl {
namespace {

/// The user of the installed service (docker/packaging/debian/sysusers.conf).
constexpr char kServiceUser[] = "hapticd";

/// Names that a hapticd that serves at `server` may have given its socket, by
/// server/owner/local/control_socket.hpp: it may listen on all addresses, or have another word for
/// this.
std::vector<std::string> control_names(const std::string& server) {
  constexpr std::string_view kUnix = "unix:", kLocal = "local:";
  if (server.rfind(kUnix, 0) == 0) return {"hapticd" + server.substr(kUnix.size())};
  if (server.rfind(kLocal, 0) == 0) return {"hapticd/" + server.substr(kLocal.size())};
  const std::size_t colon = std::min(server.rfind(':'), server.size());
  const std::string host = server.substr(0, colon), port = server.substr(colon);
  std::vector<std::string> hosts{host};
  if (host.rfind("127.", 0) == 0) hosts = {host, "0.0.0.0", "[::]"};
  if (host == "[::1]") hosts = {host, "[::]"};
  if (host == "localhost") hosts = {host, "127.0.0.1", "[::1]", "0.0.0.0", "[::]"};
  if (host == "127.0.0.1" || host == "[::1]") hosts.emplace_back("localhost");
  for (std::string& one : hosts) one = "hapticd/" + one + port;
  return hosts;
}

/// Anybody may take a name that is free, and then answer as hapticd would.
bool trusted(uid_t holder) {
  if (holder == 0 || holder == geteuid()) return true;
  const passwd* const service = getpwnam(kServiceUser);
  return service != nullptr && holder == service->pw_uid;
}

/// The whole answer; empty: none, or the socket is not a hapticd's to be believed, which is said.
std::string ask(const std::string& name, const std::string& command, int patience_ms) {
  const int socket = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (socket < 0) return {};
  const timeval patience{patience_ms / 1000, patience_ms % 1000 * 1000};
  setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::size_t size = std::min(name.size(), sizeof address.sun_path - 1);
  std::copy_n(name.data(), size, address.sun_path + 1);
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + size);
  std::string answer;
  std::array<char, 8192> bytes{};
  ucred holder{};
  socklen_t holder_size = sizeof holder;
  if (connect(socket, reinterpret_cast<const sockaddr*>(&address), length) != 0 ||
      getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &holder, &holder_size) != 0) {
    // There is no socket of this name.
  } else if (!trusted(holder.uid)) {
    std::fprintf(stderr,
                 "hapticctl: the control socket @%s is not asked: it belongs to user %u, who is "
                 "neither root, nor you, nor '%s'\n",
                 name.c_str(), holder.uid, kServiceUser);
  } else if (send(socket, command.data(), command.size(), MSG_NOSIGNAL) > 0) {
    const ssize_t got = recv(socket, bytes.data(), bytes.size(), 0);
    if (got > 0) answer.assign(bytes.data(), static_cast<std::size_t>(got));
  }
  close(socket);
  return answer;
}

}  // namespace

std::optional<std::vector<std::string>> ask_locally(const std::string& server,
                                                    const std::string& command,
                                                    std::string* refusal, int patience_ms) {
  std::string all;
  for (const std::string& name : control_names(server)) {
    if (all.empty()) all = ask(name, command, patience_ms);
  }
  std::istringstream lines(all);
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
