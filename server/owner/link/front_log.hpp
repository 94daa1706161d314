#pragma once
/// Words of a front in the owner's log: its standard output and error are a socket whose other end
/// is here. So a front holds no terminal and no file of the owner's.

#include <string>
#include <string_view>

#include "haptic/core/time.hpp"
#include "server/crossing/packet_socket.hpp"

namespace haptic::server {

class FrontLog {
 public:
  /// Copied in a second, with kPerLine for each line and each message, so that short ones count
  /// too; what is beyond waits in the socket, and then the front waits for it.
  static constexpr double kBytesPerSecond = 32 * 1024;
  static constexpr double kAtOnce = 2 * kBytesPerSecond;
  static constexpr std::size_t kPerLine = 64;
  static constexpr std::size_t kLongestLine = 2048;  ///< longer ones are cut into several

  explicit FrontLog(Descriptor socket);
  ~FrontLog();
  FrontLog(const FrontLog&) = delete;
  FrontLog& operator=(const FrontLog&) = delete;

  /// To wait for; -1: nothing may be copied now.
  [[nodiscard]] int descriptor() const noexcept { return allowed_ > 0.0 ? socket_.get() : -1; }
  /// Logs each whole line, as "front: " and its text, with the level that it begins with ("<4>"),
  /// else as a warning. False: the front sent what no front sends.
  [[nodiscard]] bool copy(core::TimePoint now);

 private:
  void add(std::string_view bytes);
  void say(std::string_view line);

  Descriptor socket_;
  std::string rest_{};  ///< of a line whose end has not come
  double allowed_{kAtOnce};
  core::TimePoint filled_{};
};

}  // namespace haptic::server
