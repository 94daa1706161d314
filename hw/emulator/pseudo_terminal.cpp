#include "hw/emulator/pseudo_terminal.hpp"

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "haptic/core/error.hpp"

namespace haptic::hw::emulator {
namespace {

[[noreturn]] void fail(const char* what) {
  throw core::DeviceError(std::string("pseudo-terminal: ") + what + ": " + std::strerror(errno));
}

/// Raw from the first byte on, whatever the host does; the setting stays when this end is closed.
void make_raw(const std::string& port) {
  const int slave = ::open(port.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (slave < 0) fail(port.c_str());
  termios raw{};
  ::tcgetattr(slave, &raw);
  ::cfmakeraw(&raw);
  ::tcsetattr(slave, TCSANOW, &raw);
  ::close(slave);
}

}  // namespace

PseudoTerminal::PseudoTerminal(std::filesystem::path link) : link_(std::move(link)) {
  open();
}

PseudoTerminal::~PseudoTerminal() {
  plug(false);
}

void PseudoTerminal::plug(bool plugged) {
  if (plugged == this->plugged()) return;
  if (plugged) return open();
  ::close(handle_);
  handle_ = -1;
  std::error_code ignored;
  if (!link_.empty()) std::filesystem::remove(link_, ignored);
}

void PseudoTerminal::open() {
  handle_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  std::array<char, 128> name{};
  if (handle_ < 0 || ::grantpt(handle_) != 0 || ::unlockpt(handle_) != 0 ||
      ::ptsname_r(handle_, name.data(), name.size()) != 0) {
    fail("cannot be made");
  }
  port_ = name.data();
  make_raw(port_);
  if (link_.empty()) return;
  // A new link is moved over the old one, so that a reader always finds one of the two.
  const std::filesystem::path fresh = link_.string() + ".new";
  std::filesystem::remove(fresh);
  std::filesystem::create_symlink(port_, fresh);
  std::filesystem::rename(fresh, link_);
}

std::vector<std::uint8_t> PseudoTerminal::read() {
  std::vector<std::uint8_t> bytes(4096);
  const ssize_t count = plugged() ? ::read(handle_, bytes.data(), bytes.size()) : 0;
  bytes.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
  return bytes;
}

std::size_t PseudoTerminal::write(std::span<const std::uint8_t> bytes) {
  if (!plugged() || bytes.empty()) return 0;
  const ssize_t count = ::write(handle_, bytes.data(), bytes.size());
  return count > 0 ? static_cast<std::size_t>(count) : 0;
}

}  // namespace haptic::hw::emulator
