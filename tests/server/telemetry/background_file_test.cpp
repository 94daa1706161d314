// Whoever records never waits for the disk.
#include "server/telemetry/background_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <condition_variable>
#include <fstream>
#include <mutex>
#include <sstream>

#include "haptic/core/error.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::server {
namespace {

using Clock = std::chrono::steady_clock;

TEST(BackgroundFile, KeepsTheOrderOfAppends) {
  const test::TemporaryFile scratch;
  std::string expected;
  {
    BackgroundFile file(scratch.path());
    for (int i = 0; i < 100'000; ++i) {
      const std::string line = std::to_string(i) + "\n";
      ASSERT_TRUE(file.append(line));
      expected += line;
    }
  }
  std::stringstream found;
  found << std::ifstream(scratch.path()).rdbuf();
  EXPECT_EQ(found.str(), expected);
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
  auto file = std::make_unique<BackgroundFile>(scratch.path(), hang->write(hang));
  const std::string text(4096, 'x');
  const auto begin = Clock::now();
  std::size_t taken = 0;
  for (int i = 0; i < 10'000; ++i) taken += file->append(text) ? text.size() : 0;
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(5));
  EXPECT_GE(taken, BackgroundFile::kMostWaiting - text.size());
  EXPECT_LT(taken, 2 * BackgroundFile::kMostWaiting);
  EXPECT_FALSE(file->ended());
  file.reset();
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(20));
  {
    const std::lock_guard lock(hang->mutex);
    hang->released = true;
  }
  hang->changed.notify_all();
}

TEST(BackgroundFile, AFullDiskEndsIt) {
  BackgroundFile file("/dev/full");
  const std::string text(4096, 'x');
  const auto give_up = Clock::now() + std::chrono::seconds(20);
  while (!file.ended() && Clock::now() < give_up) static_cast<void>(file.append(text));
  EXPECT_TRUE(file.ended());
  EXPECT_FALSE(file.append(text));
}

TEST(BackgroundFile, RefusesAnUnreadPipe) {
  const test::ScratchFolder folder;
  const auto path = folder.path() / "pipe";
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  EXPECT_THROW(BackgroundFile{path}, core::SceneError);
}

}  // namespace
}  // namespace haptic::server
