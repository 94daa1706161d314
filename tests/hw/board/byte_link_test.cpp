#include "hw/board/byte_link.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <memory>

#include "haptic/core/error.hpp"
#include "hw/emulator/pseudo_terminal.hpp"
#include "tests/support/message_of.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::hw::board {
namespace {

std::string why(int error, const std::string& port) {
  return test::message_of<core::DeviceError>([&] { throw_cannot_open(port, error); });
}

/// The group of a file by coreutils.
std::string group_of(const std::string& path) {
  const std::unique_ptr<FILE, int (*)(FILE*)> answer(
      ::popen(("stat -c %G '" + path + "'").c_str(), "r"), &::pclose);
  char name[64] = "";
  if (answer != nullptr && std::fgets(name, sizeof name, answer.get()) == nullptr) return {};
  return std::string(name).substr(0, std::string(name).find('\n'));
}

TEST(ByteLink, APermissionErrorNamesTheGroup) {
  const test::TemporaryFile port("", "ttyACM0");
  const std::string path = port.path().string(), group = group_of(path);
  ASSERT_FALSE(group.empty());
  for (const int error : {EACCES, EPERM}) {
    const std::string text = why(error, path);
    EXPECT_EQ(text.find(path + ": "), 0U) << text;
    EXPECT_NE(text.find("it belongs to the group " + group), std::string::npos) << text;
    EXPECT_NE(text.find("usermod -aG " + group), std::string::npos) << text;
  }
  EXPECT_NE(why(ENOENT, path).find("is the board plugged in?"), std::string::npos);
  EXPECT_NE(why(EBUSY, path).find("in use by another program"), std::string::npos);
}

TEST(ByteLink, APseudoTerminalOpensOnce) {
  const emulator::PseudoTerminal terminal("");
  const std::string port = terminal.port().string();
  auto first = open_link(port, 921600);
  EXPECT_EQ(test::message_of<core::DeviceError>([&] { return open_link(port, 921600); }),
            port + ": is in use by another program; must be free");
  first.reset();
  EXPECT_NO_THROW(static_cast<void>(open_link(port, 921600)));
}

/// With a pseudo-terminal in place of a serial port: the kernel's terminals share this flag.
TEST(ByteLink, OnePortOneProgram) {
  const emulator::PseudoTerminal terminal("");
  const int port = ::open(terminal.port().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  ASSERT_GE(port, 0);
  int exclusive = -1;
  ASSERT_EQ(::ioctl(port, TIOCGEXCL, &exclusive), 0);
  EXPECT_EQ(exclusive, 0);
  EXPECT_TRUE(keep_others_out(port));
  ASSERT_EQ(::ioctl(port, TIOCGEXCL, &exclusive), 0);
  EXPECT_EQ(exclusive, 1);
  ::close(port);
}

TEST(ByteLink, LowLatencyIsOptional) {
  emulator::PseudoTerminal terminal("");
  const auto link = open_link(terminal.port().string(), 921600);
  EXPECT_FALSE(ask_for_low_latency(link->handle()));
  EXPECT_FALSE(ask_for_low_latency(-1));
  EXPECT_TRUE(link->notes().empty());
  const std::array<std::uint8_t, 3> sent{0x00, 0x0D, 0xFF};
  ASSERT_EQ(link->write(sent), 3) << "the port works as before";
  EXPECT_EQ(terminal.read(), std::vector<std::uint8_t>(sent.begin(), sent.end()));
}

TEST(ByteLink, ASlowFtdiTimerIsReported) {
  const test::TemporaryFile timer("16\n", "latency_timer");
  const auto devices = timer.path().parent_path().parent_path();
  const std::string port = "/dev/" + timer.path().parent_path().filename().string();
  const std::string note = latency_timer_note(port, devices);
  EXPECT_NE(note.find("latency timer is 16 ms"), std::string::npos) << note;
  EXPECT_NE(note.find("sudo tee " + timer.path().string()), std::string::npos) << note;
  std::ofstream(timer.path()) << "15\n";
  EXPECT_EQ(latency_timer_note(port, devices), "") << "whoever changed it knows why";
  std::ofstream(timer.path()) << "1\n";
  EXPECT_EQ(latency_timer_note(port, devices), "");
  EXPECT_EQ(latency_timer_note("/dev/ttyACM0", devices), "") << "no FTDI chip, no timer";
}

}  // namespace
}  // namespace haptic::hw::board
