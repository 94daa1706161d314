// The caller never waits for the disk, and the file ends at a whole line.
#include "server/owner/telemetry/background_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "tests/support/file_text.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::server {
namespace {

using Clock = std::chrono::steady_clock;

TEST(BackgroundFile, KeepsTheOrderOfAppends) {
  const test::TemporaryFile scratch;
  std::string expected;
  {
    BackgroundFile file(create_file(scratch.path(), true));
    for (int i = 0; i < 100'000; ++i) {
      const std::string line = std::to_string(i) + "\n";
      ASSERT_TRUE(file.append(line));
      expected += line;
    }
  }
  EXPECT_EQ(test::file_text(scratch.path()), expected);
}

/// A disk that hangs until it is let go.
struct Hang {
  std::mutex mutex;
  std::condition_variable changed;
  bool released{false};
  BackgroundFile::Write write(const std::shared_ptr<Hang>& self) {
    return [self](int, const void*, std::size_t size) {
      std::unique_lock lock(self->mutex);
      self->changed.wait(lock, [&] { return self->released; });
      return static_cast<ssize_t>(size);
    };
  }
};

TEST(BackgroundFile, HangingDiskBlocksNoAppend) {
  const test::TemporaryFile scratch;
  const auto hang = std::make_shared<Hang>();
  auto file =
      std::make_unique<BackgroundFile>(create_file(scratch.path(), true), false, hang->write(hang));
  const std::string text(4096, 'x');
  const auto begin = Clock::now();
  std::size_t taken = 0;
  for (int i = 0; i < 10'000; ++i) taken += file->append(text) ? text.size() : 0;
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(5));
  EXPECT_GE(taken, BackgroundFile::kMostWaiting - text.size());
  EXPECT_LE(taken, 2 * BackgroundFile::kMostWaiting);  // what is being written, and what waits
  EXPECT_FALSE(file->ended());
  file.reset();
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(20));
  {
    const std::lock_guard lock(hang->mutex);
    hang->released = true;
  }
  hang->changed.notify_all();
}

TEST(BackgroundFile, IsWrittenWithinAQuarterSecond) {
  const test::TemporaryFile scratch;
  BackgroundFile file(create_file(scratch.path(), true));
  ASSERT_TRUE(file.append("one line\n"));
  const auto give_up = Clock::now() + std::chrono::minutes(1);
  while (std::filesystem::file_size(scratch.path()) == 0 && Clock::now() < give_up) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(std::filesystem::file_size(scratch.path()), 9U);  // while it is still open
}

/// Takes `room` bytes, then answers as a full disk.
BackgroundFile::Write disk_of(std::size_t room) {
  return [left = room](int file, const void* data, std::size_t size) mutable -> ssize_t {
    if (left == 0) {
      errno = ENOSPC;
      return -1;
    }
    const ssize_t done = ::write(file, data, std::min(size, left));
    left -= static_cast<std::size_t>(done);
    return done;
  };
}

TEST(BackgroundFile, FullDiskLeavesWholeLines) {
  for (const auto& [room, expected] :
       {std::pair{10, "ab\ncdef\n"}, std::pair{8, "ab\ncdef\n"}, std::pair{7, "ab\n"},
        std::pair{3, "ab\n"}, std::pair{2, ""}, std::pair{0, ""}}) {
    const test::TemporaryFile scratch;
    {
      BackgroundFile file(create_file(scratch.path(), true), false,
                          disk_of(static_cast<std::size_t>(room)));
      for (const char* line : {"ab\n", "cdef\n", "ghi\n"}) ASSERT_TRUE(file.append(line));
    }
    EXPECT_EQ(test::file_text(scratch.path()), expected) << room;
  }
}

/// Appends lines of 100 bytes under RLIMIT_FSIZE, until the file has ended.
[[noreturn]] void write_beyond_limit(const NewFile& opened) {
  const rlimit limit{20'050, 20'050};
  setrlimit(RLIMIT_FSIZE, &limit);
  BackgroundFile file(opened);
  const std::string line = std::string(99, 'x') + '\n';
  const auto give_up = Clock::now() + std::chrono::minutes(1);
  while (!file.ended() && Clock::now() < give_up) static_cast<void>(file.append(line));
  _exit(file.ended() && !file.append(line) ? 0 : 1);
}

/// The kernel sends SIGXFSZ to a thread that writes beyond the limit, which ends a process.
TEST(BackgroundFile, FileSizeLimitEndsNoProcess) {
  const test::TemporaryFile scratch;
  const NewFile opened = create_file(scratch.path(), true);
  EXPECT_EXIT(write_beyond_limit(opened), testing::ExitedWithCode(0), "");
  EXPECT_EQ(std::filesystem::file_size(scratch.path()), 20'000U);
}

}  // namespace
}  // namespace haptic::server
