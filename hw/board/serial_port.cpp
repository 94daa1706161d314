/// Real serial ports, by libserialport.

#include <libserialport.h>
#include <linux/serial.h>
#include <sys/ioctl.h>

#include <fstream>

#include "haptic/core/error.hpp"
#include "hw/board/byte_link.hpp"

namespace haptic::hw::board {
namespace {

/// FTDI chips collect bytes for this long before they send them on; the driver's default is 16.
constexpr int kSlowLatencyTimerMs = 16;

void throw_unless(sp_return result, const std::string& port, const char* what) {
  if (result == SP_OK) return;
  if (result == SP_ERR_FAIL && sp_last_error_code() != 0) {
    throw_cannot_open(port, sp_last_error_code());
  }
  throw core::DeviceError(port + ": cannot " + what + "; must be a serial port");
}

class SerialPort final : public ByteLink {
 public:
  SerialPort(const std::string& name, int baud) {
    throw_unless(sp_get_port_by_name(name.c_str(), &port_), name, "be found");
    try {
      open(name, baud);
    } catch (...) {
      release();
      throw;
    }
  }
  ~SerialPort() override { release(); }

  [[nodiscard]] int handle() const noexcept override { return fd_; }
  [[nodiscard]] std::ptrdiff_t read(std::span<std::uint8_t> bytes) noexcept override {
    const sp_return count = sp_nonblocking_read(port_, bytes.data(), bytes.size());
    return count < 0 ? -1 : static_cast<std::ptrdiff_t>(count);
  }
  [[nodiscard]] std::ptrdiff_t write(std::span<const std::uint8_t> bytes) noexcept override {
    const sp_return count = sp_nonblocking_write(port_, bytes.data(), bytes.size());
    return count < 0 ? -1 : static_cast<std::ptrdiff_t>(count);
  }

 private:
  void open(const std::string& name, int baud) {
    throw_unless(sp_open(port_, SP_MODE_READ_WRITE), name, "be opened");
    opened_ = true;
    throw_unless(sp_get_port_handle(port_, &fd_), name, "be used");
    claim(fd_, name);
    static_cast<void>(keep_others_out(fd_));
    throw_unless(sp_set_baudrate(port_, baud), name, "be set to that speed");
    throw_unless(sp_set_bits(port_, 8), name, "be set to 8 bits");
    throw_unless(sp_set_parity(port_, SP_PARITY_NONE), name, "be set to no parity");
    throw_unless(sp_set_stopbits(port_, 1), name, "be set to 1 stop bit");
    throw_unless(sp_set_flowcontrol(port_, SP_FLOWCONTROL_NONE), name, "be set to no flow control");
    throw_unless(sp_flush(port_, SP_BUF_BOTH), name, "be flushed");
    static_cast<void>(ask_for_low_latency(fd_));
    if (std::string note = latency_timer_note(name); !note.empty()) notes_.push_back(note);
  }

  void release() noexcept {
    if (opened_) sp_close(port_);
    if (port_ != nullptr) sp_free_port(port_);
  }

  sp_port* port_{nullptr};
  bool opened_{false};
  int fd_{-1};
};

}  // namespace

bool keep_others_out(int handle) noexcept {
  return ::ioctl(handle, TIOCEXCL) == 0;
}

bool ask_for_low_latency(int handle) noexcept {
  serial_struct settings{};
  if (::ioctl(handle, TIOCGSERIAL, &settings) != 0) return false;
  settings.flags |= ASYNC_LOW_LATENCY;
  return ::ioctl(handle, TIOCSSERIAL, &settings) == 0;
}

std::string latency_timer_note(const std::string& port, const std::filesystem::path& devices) {
  const auto setting = devices / std::filesystem::path(port).filename() / "latency_timer";
  std::ifstream file(setting);
  int timer_ms = 0;
  if (!(file >> timer_ms) || timer_ms < kSlowLatencyTimerMs) return {};
  return port + ": the FTDI latency timer is " + std::to_string(timer_ms) +
         " ms, so samples come late and in bursts; must be 1 (echo 1 | sudo tee " +
         setting.string() + ")";
}

std::unique_ptr<ByteLink> open_serial_port(const std::string& port, int baud) {
  return std::make_unique<SerialPort>(port, baud);
}

}  // namespace haptic::hw::board
