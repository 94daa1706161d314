#pragma once
/// Bytes to and from a board. Two kinds: real serial ports by libserialport, pseudo-terminals by
/// POSIX (libserialport 0.1.1 cannot open those: it asks sysfs and TIOCMGET).

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace haptic::hw::board {

class ByteLink {
 public:
  virtual ~ByteLink() = default;
  ByteLink(const ByteLink&) = delete;
  ByteLink& operator=(const ByteLink&) = delete;

  /// File descriptor for poll(): readable when bytes have come or the link is gone.
  [[nodiscard]] virtual int handle() const noexcept = 0;
  /// Never block. Return the number of bytes; 0 if there are none (no room) now; -1 if the link is
  /// gone.
  [[nodiscard]] virtual std::ptrdiff_t read(std::span<std::uint8_t> bytes) noexcept = 0;
  [[nodiscard]] virtual std::ptrdiff_t write(std::span<const std::uint8_t> bytes) noexcept = 0;
  /// Warnings from opening the port, for people: an FTDI latency timer of 16 ms.
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }

 protected:
  ByteLink() = default;
  std::vector<std::string> notes_{};
};

/// Opens the port for this process alone. `baud` is for real ports (USB ignores it). Throws
/// DeviceError: no such port, used by another program, no permission (naming the group that has
/// it).
[[nodiscard]] std::unique_ptr<ByteLink> open_link(const std::string& port, int baud);

/// The two kinds, and what they share.
[[nodiscard]] std::unique_ptr<ByteLink> open_terminal(const std::string& port);
[[nodiscard]] std::unique_ptr<ByteLink> open_serial_port(const std::string& port, int baud);
/// Locks an open port against other processes; throws DeviceError naming `port` if one has it.
void claim(int handle, const std::string& port);
/// Keeps other programs (except root's) from opening the port, even if they ignore locks. False if
/// the driver cannot. For real ports only: on a pseudo-terminal it would outlast this program.
bool keep_others_out(int handle) noexcept;
/// Asks the driver to pass bytes on as they come. Only a hint: false, without harm, if the driver
/// does not know it, for example USB CDC and pseudo-terminals.
bool ask_for_low_latency(int handle) noexcept;
/// The warning about an FTDI chip whose latency timer is 16 ms or more; empty if the port has none
/// or a shorter one. `devices`: the folder of sysfs with one folder per USB serial port.
[[nodiscard]] std::string latency_timer_note(
    const std::string& port, const std::filesystem::path& devices = "/sys/bus/usb-serial/devices");
/// DeviceError for a port that could not be opened because of `error` (errno).
[[noreturn]] void throw_cannot_open(const std::string& port, int error);

}  // namespace haptic::hw::board
