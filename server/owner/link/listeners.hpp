#pragma once
/// The sockets that a scene names, bound by the owner once for all fronts of this daemon: no other
/// process gets a port while a front is replaced.

#include <sys/socket.h>
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
///
/// A front shares them with the owner, and may shut down, connect or filter them for every front
/// after it. So they are opened again after a front that did not end in order or could give away
/// copies, and if a look at them shows a change. The new one is bound before the old one is closed:
/// no other user's program gets the port in between.
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
  /// No front may have the sockets. Opens each again that is not as it was made, and logs it.
  /// Throws core::TransportError if that fails.
  void check();
  /// A front can pass copies to a user of this host who connects to a UNIX socket.
  [[nodiscard]] bool may_be_copied() const noexcept { return !files_.empty(); }
  /// Opens all of them again; one that cannot be opened stays for check().
  void try_to_open_again() noexcept;

 private:
  /// A UNIX socket's; one that another server put there since then stays.
  struct File {
    explicit File(std::string path);
    ~File();
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    [[nodiscard]] bool is_of_another() const;
    const std::string path;
    dev_t device{0};
    ino_t inode{0};
  };
  void bind_unix(const std::string& address, const std::string& path);
  /// A name may stand for several addresses; the answer has the port filled in.
  [[nodiscard]] std::string bind_name(const std::string& address, int type);

  std::vector<FrontConfig::Address> addresses_{};
  std::string udp_listen_{};
  struct Bound {
    Descriptor socket{};
    int type{0};
    sockaddr_storage name{};  ///< with its port
    socklen_t size{0};
    std::vector<int> state{};  ///< look_at() it as it was made
  };
  void keep(Descriptor socket, int type);
  void open_again(Bound& bound);

  std::vector<Bound> sockets_{};
  std::vector<std::unique_ptr<File>> files_{};  ///< of those that have one, in the same order
};

}  // namespace haptic::server
