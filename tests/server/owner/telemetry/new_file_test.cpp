// A recording never overwrites, follows or shares a file.
#include "server/owner/telemetry/new_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <string>

#include "haptic/core/error.hpp"
#include "tests/support/file_text.hpp"
#include "tests/support/message_of.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::server {
namespace {

namespace fs = std::filesystem;

class NewFileTest : public testing::Test {
 protected:
  const test::ScratchFolder folder{};
  const fs::path run = folder.path() / "run.csv";

  static void write(const NewFile& file, const std::string& text) {
    EXPECT_EQ(::write(file.descriptor, text.data(), text.size()),
              static_cast<ssize_t>(text.size()));
  }
  /// Message of create_file() and check_creatable(); both must refuse for the same reason.
  static std::string refused(const fs::path& path, bool overwrite) {
    const auto said = test::message_of<core::SceneError>([&] { check_creatable(path, overwrite); });
    EXPECT_EQ(test::message_of<core::SceneError>([&] { return create_file(path, overwrite); }),
              said);
    return said;
  }
};

TEST_F(NewFileTest, FormerRecordingStays) {
  const char* const texts[] = {"first", "second", "third"};
  for (const char* text : texts) {
    const NewFile file = create_file(run, false);
    write(file, text);
    ::close(file.descriptor);
  }
  EXPECT_EQ(test::file_text(run), "first");
  EXPECT_EQ(test::file_text(folder.path() / "run-2.csv"), "second");
  EXPECT_EQ(test::file_text(folder.path() / "run-3.csv"), "third");
}

TEST_F(NewFileTest, OverwriteEmptiesTheFormer) {
  std::ofstream(run) << "a former recording";
  const NewFile file = create_file(run, true);
  EXPECT_EQ(file.path, run);
  write(file, "new");
  ::close(file.descriptor);
  EXPECT_EQ(test::file_text(run), "new");
}

TEST_F(NewFileTest, FilesInUseAreNotOverwritten) {
  for (const bool first_overwrites : {false, true}) {
    const fs::path path = folder.path() / (first_overwrites ? "a.csv" : "b.csv");
    const NewFile first = create_file(path, first_overwrites);
    write(first, "kept");
    EXPECT_THROW(static_cast<void>(create_file(path, true)), core::SceneError);
    EXPECT_EQ(test::file_text(path), "kept");
    ::close(first.descriptor);
    ::close(create_file(path, true).descriptor);
    EXPECT_EQ(test::file_text(path), "");
  }
}

TEST_F(NewFileTest, NoLinkIsFollowed) {
  const fs::path victim = folder.path() / "victim";
  std::ofstream(victim) << "precious";
  fs::create_symlink(victim, run);
  const fs::path dangling = folder.path() / "dangling.csv";
  fs::create_symlink(folder.path() / "made", dangling);
  for (const bool overwrite : {false, true}) {
    EXPECT_THAT(refused(run, overwrite), testing::HasSubstr("run.csv': cannot be created: is a "
                                                            "symbolic link"));
    EXPECT_THAT(refused(dangling, overwrite), testing::HasSubstr("is a symbolic link"));
  }
  EXPECT_EQ(test::file_text(victim), "precious");
  EXPECT_FALSE(fs::exists(folder.path() / "made"));
}

TEST_F(NewFileTest, OnlyRegularFilesAreWritten) {
  const fs::path pipe = folder.path() / "pipe.csv";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const bool overwrite : {false, true}) {
    EXPECT_THAT(refused(pipe, overwrite), testing::HasSubstr("is no regular file"));
    EXPECT_THAT(refused(folder.path(), overwrite), testing::HasSubstr("is no regular file"));
    EXPECT_THAT(refused("/dev/full", overwrite), testing::HasSubstr("is no regular file"));
    EXPECT_THAT(refused("/proc/no/such/folder/run.csv", overwrite),
                testing::HasSubstr("run.csv': cannot be created: No such file or directory"));
  }
}

TEST_F(NewFileTest, CheckingCreatesNothing) {
  check_creatable(run, false);
  check_creatable(run, true);
  EXPECT_FALSE(fs::exists(run));
}

}  // namespace
}  // namespace haptic::server
