#include "server/owner/local/control_listeners.hpp"

#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "haptic/core/error.hpp"
#include "haptic/wire/control_names.hpp"
#include "server/crossing/packet_socket.hpp"

namespace haptic::server {
namespace {

/// Callers that wait to be accepted. A turn takes them all (ControlSocket), so that a flood of one
/// user leaves no long queue in front of another.
constexpr int kWaiting = 256;

struct Address {
  /// `name`: a file, or a name of the abstract namespace behind a zero byte.
  explicit Address(const std::string& name) {
    if (name.size() >= sizeof value.sun_path) {
      throw core::TransportError("control socket '" + name + "': the name is too long");
    }
    value.sun_family = AF_UNIX;
    std::copy(name.begin(), name.end(), value.sun_path);
    const std::size_t end = name.empty() || name.front() == '\0' ? 0 : 1;
    size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size() + end);
  }
  [[nodiscard]] const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&value); }
  sockaddr_un value{};
  socklen_t size{0};
};

Descriptor new_socket() {
  return Descriptor(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

/// "user 1000"; empty: no process listens there.
std::string holder(const Address& address) {
  const Descriptor caller = new_socket();
  const int connected = connect(caller.get(), address.get(), address.size);
  if (connected != 0 && errno != EAGAIN) return {};
  ucred peer{};
  socklen_t size = sizeof peer;
  getsockopt(caller.get(), SOL_SOCKET, SO_PEERCRED, &peer, &size);
  return connected == 0 ? "user " + std::to_string(peer.uid) : "a program that does not answer";
}

/// A folder of this user that no other one may change.
bool is_own_folder(const std::string& path) {
  struct stat status {};
  return lstat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode) &&
         status.st_uid == geteuid() && (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

}  // namespace

std::string control_folder() {
  const std::string common = wire::kControlFolder;
  if (geteuid() == 0) mkdir(common.c_str(), 0755);
  if (is_own_folder(common)) return common;
  const char* const given = std::getenv("XDG_RUNTIME_DIR");
  const std::string runtime = given != nullptr ? given : "/run/user/" + std::to_string(geteuid());
  if (!is_own_folder(runtime)) return {};
  const std::string own = runtime + wire::kControlSubfolder;
  mkdir(own.c_str(), 0755);
  constexpr std::size_t kLongestFile = 54;  // control_file(), "/" and ".all"
  const bool fits = own.size() + kLongestFile < sizeof(sockaddr_un::sun_path);
  return fits && is_own_folder(own) ? own : std::string();
}

ControlListeners::ControlListeners(const ControlPlaces& places) {
  std::string told;
  for (const std::string& name : places.names) {
    const std::string file = wire::control_file(name);
    const std::string abstract = wire::kAbstractPrefix + file;
    if (!places.folder.empty()) {
      const std::string path = places.folder + "/" + file;
      bind_file(path, false);
      bind_file(path + wire::kForAll, true);
      told += (told.empty() ? "" : ", ") + path;
    }
    if (bind_abstract(abstract)) {
      told += (told.empty() ? "@" : ", @") + abstract;
      continue;
    }
    const std::string why =
        "control socket '@" + abstract + "': in use by " + holder(Address('\0' + abstract));
    if (places.folder.empty()) {
      throw core::TransportError(why +
                                 ", so that there would be no local stop: name a folder that is "
                                 "this user's and that no other one can change, "
                                 "XDG_RUNTIME_DIR=FOLDER, to hapticd and to hapticctl");
    }
    spdlog::warn("{}: local stops go by {} only", why, places.folder);
  }
  spdlog::info("local control socket: {}", told);
}

ControlListeners::~ControlListeners() {
  for (const std::string& file : files_) unlink(file.c_str());
}

void ControlListeners::bind_file(const std::string& path, bool for_all) {
  const Address address(path);
  const auto fail = [&](const std::string& why) {
    return core::TransportError("control socket '" + path + "': " + why);
  };
  if (const std::string other = holder(address); !other.empty()) {
    throw fail("another hapticd has it, of " + other);
  }
  unlink(path.c_str());  // of one that was killed
  Descriptor made = new_socket();
  fchmod(made.get(), 0600);  // before it has a name: no other user ever sees it wider
  refuse_descriptors(made.get());
  if (bind(made.get(), address.get(), address.size) != 0) throw fail(std::strerror(errno));
  files_.push_back(path);
  if (for_all) chmod(path.c_str(), 0666);
  if (listen(made.get(), kWaiting) != 0) throw fail(std::strerror(errno));
  listeners_.push_back({std::move(made), for_all});
}

bool ControlListeners::bind_abstract(const std::string& name) {
  const Address address('\0' + name);
  Descriptor made = new_socket();
  refuse_descriptors(made.get());
  if (bind(made.get(), address.get(), address.size) != 0 || listen(made.get(), kWaiting) != 0) {
    return false;
  }
  listeners_.push_back({std::move(made), true});
  return true;
}

}  // namespace haptic::server
