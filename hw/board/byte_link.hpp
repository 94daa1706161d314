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

  /// To wait on with poll(); readable when bytes have come, or the link is gone.
  [[nodiscard]] virtual int handle() const noexcept = 0;
  /// Never block. Number of bytes, 0 where there are none (no room) just now, -1: the link is gone.
  [[nodiscard]] virtual std::ptrdiff_t read(std::span<std::uint8_t> bytes) noexcept = 0;
  [[nodiscard]] virtual std::ptrdiff_t write(std::span<const std::uint8_t> bytes) noexcept = 0;
  /// What was found at the opening that a person should know: an FTDI latency timer of 16 ms.
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }

 protected:
  ByteLink() = default;
  std::vector<std::string> notes_{};
};

/// Opens the port for this process alone. `baud` is for real ports (USB ignores it). Throws
/// DeviceError: no such port, another program has it, no permission (naming the group that has it).
[[nodiscard]] std::unique_ptr<ByteLink> open_link(const std::string& port, int baud);

/// The two kinds, and what they share.
[[nodiscard]] std::unique_ptr<ByteLink> open_terminal(const std::string& port);
[[nodiscard]] std::unique_ptr<ByteLink> open_serial_port(const std::string& port, int baud);
/// Locks an open port against other processes; throws DeviceError naming `port` if one has it.
void claim(int handle, const std::string& port);
/// Where the driver can: no other program opens the port meanwhile, also one that does not ask for
/// locks (but root does). For real ports: of a pseudo-terminal it would outlive this program.
bool keep_others_out(int handle) noexcept;
/// Asks the driver to hand bytes on as they come. A hint: false where it knows of none, as USB CDC
/// and pseudo-terminals, and no harm done.
bool ask_for_low_latency(int handle) noexcept;
/// What to tell of an FTDI chip whose latency timer is 16 ms or more; empty where there is none, or
/// it is short. `devices`: the folder of sysfs with one folder per USB serial port.
[[nodiscard]] std::string latency_timer_note(
    const std::string& port, const std::filesystem::path& devices = "/sys/bus/usb-serial/devices");
/// DeviceError for a port that could not be opened because of `error` (errno).
[[noreturn]] void throw_cannot_open(const std::string& port, int error);

}  // namespace haptic::hw::board
