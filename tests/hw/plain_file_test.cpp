#include "hw/plain_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "haptic/core/error.hpp"
#include "hw/motion/motion_csv.hpp"
#include "tests/support/message_of.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::hw {
namespace {

using testing::HasSubstr;

std::string why(const std::filesystem::path& file, std::uintmax_t most = 100) {
  std::string said;
  EXPECT_EQ(read_plain_file(file, most, said), "");
  return said;
}

TEST(PlainFile, IsReadUpToItsLimit) {
  const test::TemporaryFile file("0123456789", "plain.txt");
  std::string said;
  EXPECT_EQ(read_plain_file(file.path(), 10, said), "0123456789");
  EXPECT_EQ(said, "");
  EXPECT_THAT(why(file.path(), 9), HasSubstr("has 10 bytes, must have at most 9"));
}

TEST(PlainFile, OnlyUtf8IsRead) {
  std::string said;
  EXPECT_EQ(read_plain_file(test::TemporaryFile("\xEF\xBB\xBF#").path(), 10, said), "#");
  EXPECT_EQ(said, "");
  for (const char* mark : {"\xFF\xFE#", "\xFE\xFF#"}) {
    EXPECT_EQ(why(test::TemporaryFile(mark).path()), "is UTF-16, must be UTF-8");
  }
}

TEST(PlainFile, NothingElseIsReadOrAwaited) {
  const std::string pipe = testing::TempDir() + "pipe-" + std::to_string(getpid());
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(why(pipe), HasSubstr("must be a plain file"));
  EXPECT_THAT(test::message_of<core::DeviceError>([&] { return motion_columns(pipe); }),
              HasSubstr("must be a plain file"));
  unlink(pipe.c_str());
  EXPECT_THAT(why("/dev/zero"), HasSubstr("must be a plain file"));
  EXPECT_THAT(why("/no/such"), HasSubstr("cannot be read: No such file"));
  EXPECT_THAT(why("/"), HasSubstr("is a folder"));
}

}  // namespace
}  // namespace haptic::hw
