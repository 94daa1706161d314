#pragma once
/// The sockets that a scene names, bound by the owner once for all fronts of this daemon: no other
/// process gets a port while a front is replaced.

#include <sys/types.h>

#include <memory>
#include <string>
#include <vector>

#include "server/crossing/front_config.hpp"
#include "server/owner/scene/scene.hpp"

namespace haptic::server {

/// The protection of `address`, whose form is that of address_problem(); `best` is the best that
/// the server can offer. Throws core::TransportError naming the address: a host other than loopback
/// with `best` kThisHost (plain text stays on this machine); a UNIX socket that another process
/// answers on, or a path that is no socket.
Protection check_listen_address(const std::string& address,
                                Protection best = Protection::kThisHost);

/// Bound and listening, non-blocking. The files of UNIX sockets are removed at the end.
class Listeners {
 public:
  /// Binds every address of `scene`. Throws core::TransportError naming the one that is wrong or
  /// cannot be bound.
  Listeners(const ServerScene& scene, bool insecure_lab);

  /// The addresses for FrontConfig.
  [[nodiscard]] const std::vector<FrontConfig::Address>& addresses() const noexcept {
    return addresses_;
  }
  [[nodiscard]] const std::string& udp_listen() const noexcept { return udp_listen_; }
  /// Copies of the sockets, for FrontStart.
  [[nodiscard]] std::vector<Descriptor> sockets() const;

 private:
  /// A UNIX socket's; one that another server put there since then stays.
  struct File {
    explicit File(std::string path);
    ~File();
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    const std::string path;
    dev_t device{0};
    ino_t inode{0};
  };
  void bind_unix(const std::string& address, const std::string& path);
  /// A name may stand for several addresses; the answer has the port filled in.
  [[nodiscard]] std::string bind_name(const std::string& address, int type);

  std::vector<FrontConfig::Address> addresses_{};
  std::string udp_listen_{};
  std::vector<Descriptor> sockets_{};
  std::vector<std::unique_ptr<File>> files_{};
};

}  // namespace haptic::server
