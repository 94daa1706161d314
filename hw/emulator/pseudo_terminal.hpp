#pragma once
/// The board's end of a pseudo-terminal, with a link to its other end under a name that stays the
/// same when it is unplugged and plugged in again.

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace haptic::hw::emulator {

class PseudoTerminal {
 public:
  /// `link`: empty, or a path to be made a symbolic link to the port. Throws DeviceError.
  explicit PseudoTerminal(std::filesystem::path link);
  ~PseudoTerminal();
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;

  /// Unplugged, the host sees its port vanish. Throws DeviceError.
  void plug(bool plugged);

  [[nodiscard]] bool plugged() const noexcept { return handle_ >= 0; }
  [[nodiscard]] int handle() const noexcept { return handle_; }  ///< -1 if unplugged
  [[nodiscard]] const std::filesystem::path& port() const noexcept { return port_; }
  /// Bytes from the host; empty if there are none, or no host.
  [[nodiscard]] std::vector<std::uint8_t> read();
  /// Returns the number of bytes that the host's side took.
  std::size_t write(std::span<const std::uint8_t> bytes);

 private:
  void open();

  std::filesystem::path link_;
  std::filesystem::path port_{};
  int handle_{-1};
};

}  // namespace haptic::hw::emulator
