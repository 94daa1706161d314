#include "local_control.hpp"

#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <sstream>
#include <string_view>

namespace haptic::ctl {
namespace {

/// As hapticd names its socket (server/owner/control_socket.hpp). Empty unless `server` is of this
/// host for certain: a port of another host may be one of this host too.
std::string control_name(const std::string& server) {
  constexpr std::string_view kUnix = "unix:", kLocal = "local:";
  if (server.rfind(kUnix, 0) == 0) return "hapticd" + server.substr(kUnix.size());
  if (server.rfind(kLocal, 0) == 0) return "hapticd/" + server.substr(kLocal.size());
  const std::string host = server.substr(0, server.rfind(':'));
  const bool here = host == "localhost" || host == "[::1]" || host.rfind("127.", 0) == 0;
  return here ? "hapticd/" + server.substr(server.rfind(':') + 1) : "";
}

/// The whole answer; empty: none.
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
  if (connect(socket, reinterpret_cast<const sockaddr*>(&address), length) == 0 &&
      send(socket, command.data(), command.size(), MSG_NOSIGNAL) > 0) {
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
  const std::string name = control_name(server);
  if (name.empty()) return std::nullopt;
  std::istringstream lines(ask(name, command, patience_ms));
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
