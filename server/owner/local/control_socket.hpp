#pragma once
/// The local control socket: stops the devices without the network. A connection carries one
/// command and one answer, both plain text (control_command.hpp).
///
/// Root and the user that runs hapticd are trusted. Every other user of this host may ask too, and
/// may ask without end: so trusted ones come first, have places of their own and, by a folder, a
/// socket of their own (control_listeners.hpp). The others share what is left: a bounded number of
/// places, few of one user, and only so many turns a second.

#include <poll.h>
#include <sys/types.h>

#include <functional>
#include <string_view>
#include <utility>
#include <vector>

#include "haptic/core/time.hpp"
#include "server/owner/local/control_command.hpp"
#include "server/owner/local/control_listeners.hpp"

namespace haptic::server {

class ControlSocket {
 public:
  static constexpr std::size_t kConnections = 16;  ///< of trusted users; as many of all others
  static constexpr std::size_t kPerUser = 4;       ///< of those, of one user, also in one turn
  static constexpr std::size_t kAcceptedPerTurn = 64;
  /// Others are served in so many turns of each round.
  static constexpr core::Duration kRound{std::chrono::milliseconds(5)};
  static constexpr unsigned kTurnsPerRound = 4;
  static constexpr int kMostClosing = 16;  ///< sockets whose close waits

  using Handler = std::function<void(const ControlCommand&)>;
  /// The process may ask nothing, even if its user may.
  using Barred = std::function<bool(pid_t process)>;

  /// Throws as ControlListeners.
  ControlSocket(const ControlPlaces& places, Handler handler, Barred barred = {});
  ControlSocket(const ControlSocket&) = delete;
  ControlSocket& operator=(const ControlSocket&) = delete;

  /// Adds what to poll for, before turn(); the answer: for at most how long.
  [[nodiscard]] core::Duration add_to(std::vector<pollfd>& wait, core::TimePoint now) const;
  /// Accepts and reads, a bounded number at a time, and calls the handler: first with stops, and
  /// first with those of trusted users.
  void turn(core::TimePoint now);
  /// Sends the answer and closes. A connection that is gone is ignored.
  void answer(std::uint64_t reply_to, std::string_view text);

 private:
  struct Connection {
    Descriptor socket{};
    std::uint64_t number{0};
    unsigned user{0};
    bool trusted{false};
    bool asked{false};
  };
  [[nodiscard]] bool serves_others(core::TimePoint now) const;
  /// True: somebody came.
  bool accept_from(const ControlListeners::Listener& listener);
  void accept_one(Descriptor socket);
  [[nodiscard]] bool has_too_many(unsigned user);
  void make_room(bool trusted, unsigned user);
  void read(Connection& connection);

  const Handler handler_;
  const Barred barred_;
  const ControlListeners listeners_;
  std::vector<Connection> connections_{};                     ///< the oldest first
  std::vector<ControlCommand> commands_{};                    ///< of this turn
  std::vector<std::pair<unsigned, std::size_t>> accepted_{};  ///< of this turn, by user
  core::TimePoint round_{}, others_at_{};  ///< began then; others are served from then on
  unsigned turns_{0};                      ///< of the round in which others were served
  std::uint64_t last_number_{0};
};

}  // namespace haptic::server
