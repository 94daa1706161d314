#include "server/front/web/web_content.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "haptic/core/error.hpp"
#include "tests/support/message_of.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::server {
namespace {

namespace fs = std::filesystem;

TEST(LoadPage, SaysWhatItsUserCannotRead) {
  const test::ScratchFolder folder;
  fs::permissions(folder.path(), fs::perms(0755));
  const fs::path page = folder.path() / "page", link = folder.path() / "link";
  fs::create_directory(page);
  fs::create_symlink(page, link);
  std::ofstream(page / "index.html") << "hello";
  EXPECT_EQ(load_page(link).at("/").bytes, "hello");
  EXPECT_TRUE(load_page("/dev/null").empty());
  if (geteuid() != 0) GTEST_SKIP() << "root alone becomes another user and comes back";
  const auto as_nobody = [&] {
    EXPECT_EQ(seteuid(65534), 0);
    const std::string said =
        test::message_of<core::TransportError>([&] { return load_page(link); });
    EXPECT_EQ(seteuid(0), 0);
    return said;
  };
  EXPECT_EQ(as_nobody(), "no error");
  fs::permissions(page / "index.html", fs::perms(0600));
  EXPECT_EQ(as_nobody(),
            "page: '" + (page / "index.html").string() + "' cannot be read by user 65534");
  fs::permissions(page, fs::perms(0700));
  EXPECT_EQ(as_nobody(), "page: '" + page.string() + "' cannot be read by user 65534");
}

}  // namespace
}  // namespace haptic::server
