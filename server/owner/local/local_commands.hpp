#pragma once
/// The commands of the local control socket as requests to the owner. One thread, the link's; the
/// answers come on any.

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "server/owner/local/control_socket.hpp"
#include "server/owner/rights/owner.hpp"

namespace haptic::server {

class LocalCommands {
 public:
  /// A command for the front, by its number: answered by answer().
  using OfFront = std::function<void(ControlSocket::Command::Kind kind, std::uint64_t reply_to)>;

  LocalCommands(Owner& owner, OfFront of_front) : owner_(owner), of_front_(std::move(of_front)) {}

  /// From now on the socket control_name(address) is there. Throws core::TransportError.
  void listen(const std::string& address);
  void add_to(std::vector<pollfd>& wait) const;
  /// Reads what came, and sends what was answered.
  void turn(core::TimePoint now);
  void answer(std::uint64_t reply_to, const std::string& text);

  /// An answer to one of its requests. Any thread; the link's has to be woken.
  void on_answer(const Answer& answer);

 private:
  /// A command that waits for the answers of `open` devices.
  struct Open {
    std::uint64_t reply_to{0};
    std::size_t open{0};
    std::string text{"ok"};
    bool refused{false};
    bool clear{false};
  };
  void command(const ControlSocket::Command& command);
  void ask(const ControlSocket::Command& command, const std::vector<std::size_t>& devices);

  Owner& owner_;
  const OfFront of_front_;
  std::unique_ptr<ControlSocket> control_{};
  core::TimePoint now_{};
  std::uint64_t last_id_{0};
  struct Asked {
    std::shared_ptr<Open> open{};
    std::size_t device{0};
  };
  std::unordered_map<std::uint64_t, Asked> asked_{};
  std::mutex mutex_;
  std::vector<Answer> answers_{};
};

}  // namespace haptic::server
