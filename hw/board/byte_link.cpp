#include "hw/board/byte_link.hpp"

#include <fcntl.h>
#include <grp.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "haptic/core/error.hpp"

namespace haptic::hw::board {
namespace {

class Terminal final : public ByteLink {
 public:
  explicit Terminal(const std::string& port)
      : fd_(::open(port.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
    if (fd_ < 0) throw_cannot_open(port, errno);
    try {
      claim(fd_, port);
      termios raw{};
      if (tcgetattr(fd_, &raw) != 0) throw_cannot_open(port, errno);
      cfmakeraw(&raw);
      if (tcsetattr(fd_, TCSANOW, &raw) != 0) throw_cannot_open(port, errno);
      tcflush(fd_, TCIOFLUSH);  // bytes meant for the port's previous user
    } catch (...) {
      ::close(fd_);
      throw;
    }
  }
  ~Terminal() override { ::close(fd_); }

  [[nodiscard]] int handle() const noexcept override { return fd_; }
  [[nodiscard]] std::ptrdiff_t read(std::span<std::uint8_t> bytes) noexcept override {
    const ssize_t count = ::read(fd_, bytes.data(), bytes.size());
    if (count > 0) return count;
    return count < 0 && would_block() ? 0 : -1;
  }
  [[nodiscard]] std::ptrdiff_t write(std::span<const std::uint8_t> bytes) noexcept override {
    const ssize_t count = ::write(fd_, bytes.data(), bytes.size());
    if (count >= 0) return count;
    return would_block() ? 0 : -1;
  }

 private:
  static bool would_block() noexcept {
    return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
  }
  int fd_{-1};
};

std::string group_of(const std::string& port) {
  struct stat status {};
  if (::stat(port.c_str(), &status) != 0) return {};
  const group* const entry = ::getgrgid(status.st_gid);
  return entry != nullptr ? entry->gr_name : std::to_string(status.st_gid);
}

}  // namespace

void claim(int handle, const std::string& port) {
  if (::flock(handle, LOCK_EX | LOCK_NB) != 0) {
    throw core::DeviceError(port + ": is in use by another program; must be free");
  }
}

void throw_cannot_open(const std::string& port, int error) {
  std::string text = port + ": " + std::strerror(error);
  if (error == EACCES || error == EPERM) {
    const std::string group = group_of(port);
    text += "; must be readable and writable: it belongs to the group " + group +
            " (sudo usermod -aG " + group + " $USER, and log in again)";
  } else if (error == ENOENT) {
    text += "; must be a serial port (is the board plugged in?)";
  } else if (error == EBUSY) {
    text += "; is in use by another program";
  }
  throw core::DeviceError(text);
}

std::unique_ptr<ByteLink> open_terminal(const std::string& port) {
  return std::make_unique<Terminal>(port);
}

std::unique_ptr<ByteLink> open_link(const std::string& port, int baud) {
  std::error_code missing;
  const std::filesystem::path real = std::filesystem::canonical(port, missing);
  if (missing) throw_cannot_open(port, ENOENT);
  const bool pseudo_terminal = real.string().starts_with("/dev/pts/");
  return pseudo_terminal ? open_terminal(real.string()) : open_serial_port(real.string(), baud);
}

}  // namespace haptic::hw::board
