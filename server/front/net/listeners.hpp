#pragma once
/// The sockets that the server listens on (private to the front).

#include <sys/types.h>

#include <string>
#include <vector>

#include "server/base/descriptor.hpp"

namespace haptic::server {

/// Bound and listening, non-blocking. Removes the files of its UNIX sockets at the end.
class Listeners {
 public:
  struct Socket {
    Descriptor descriptor{};
    std::size_t address{0};  ///< index of the address; a name may stand for several sockets
  };

  /// `addresses` have passed check_listen_address(). Throws core::TransportError naming the address
  /// that cannot be bound.
  explicit Listeners(const std::vector<std::string>& addresses);
  ~Listeners();
  Listeners(const Listeners&) = delete;
  Listeners& operator=(const Listeners&) = delete;

  [[nodiscard]] const std::vector<Socket>& sockets() const noexcept { return sockets_; }
  /// The port of each address as bound; 0: a UNIX socket.
  [[nodiscard]] const std::vector<int>& ports() const noexcept { return ports_; }

 private:
  struct File {
    std::string path{};
    dev_t device{0};
    ino_t inode{0};  ///< a socket that another server put there since then stays
  };
  void listen_unix(std::size_t index, const std::string& address, const std::string& path);
  void listen_tcp(std::size_t index, const std::string& address);

  std::vector<Socket> sockets_{};
  std::vector<File> files_{};
  std::vector<int> ports_{};
};

}  // namespace haptic::server
