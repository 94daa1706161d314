#pragma once
/// The local control socket: stops the devices without the network. A UNIX socket of type
/// SOCK_SEQPACKET in the abstract namespace, so that every user of this host reaches it and no file
/// is left behind; a connection carries one command and one answer, both plain text.
///
///   stop [DEVICE] [newline REASON]    every local user          "ok", a line per device
///   clear [DEVICE] [newline FAULTS]   hapticd's user and root   "ok", the bits that were cleared
///   health                            every local user          "ok" and whether a front serves
///   restart-front                     hapticd's user and root   "ok" when the new one serves
///
/// No device: all of them, or for clear the only one. FAULTS: bits, as a decimal number; none: all.
/// Anything else is answered with "refused: " and why.

#include <poll.h>

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "server/crossing/shared_memory.hpp"

namespace haptic::server {

class ControlSocket {
 public:
  static constexpr std::size_t kLongestCommand = 384;
  static constexpr std::size_t kConnections = 16;

  struct Command {
    enum class Kind : std::uint8_t { kStop, kClear, kHealth, kRestartFront };
    Kind kind{Kind::kStop};
    std::string device{};       ///< empty: all
    std::string reason{};       ///< kStop
    std::uint32_t faults{0};    ///< kClear; 0: all
    std::uint64_t reply_to{0};  ///< for answer()
    unsigned user{0};
  };
  using Handler = std::function<void(const Command&)>;

  /// `name`: control_name(). Throws core::TransportError, also if another program has the name.
  ControlSocket(const std::string& name, Handler handler);
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;

  /// Adds what to poll for, before turn().
  void add_to(std::vector<pollfd>& wait) const;
  /// Accepts, reads and calls the handler; a bounded number at a time.
  void turn();
  /// Sends the answer and closes. A connection that is gone is ignored.
  void answer(std::uint64_t reply_to, std::string_view text);

 private:
  struct Connection {
    Descriptor socket{};
    std::uint64_t number{0};
    unsigned user{0};
    bool asked{false};
  };
  void accept_one(Descriptor socket);
  void read(Connection& connection);

  Handler handler_;
  Descriptor listener_{};
  std::vector<Connection> connections_;  ///< the oldest first
  std::uint64_t last_number_{0};
};

/// The name for a daemon that serves at `address`, or whose scene is `address`: "hapticd/" and
/// that, or the path of a UNIX socket. Two daemons may have one port, at two addresses of a host.
[[nodiscard]] std::string control_name(const std::string& address);

/// The text as a command; a sentence for people if it is none.
struct ParsedCommand {
  ControlSocket::Command command{};
  std::string wrong{};  ///< empty: `command` is set
};
[[nodiscard]] ParsedCommand parse_command(std::string_view text);

}  // namespace haptic::server
