#include "haptic/wire/control_names.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

namespace {

using haptic::wire::control_file;
using haptic::wire::control_names;
using testing::ElementsAre;
using testing::UnorderedElementsAre;

TEST(ControlNames, AreThoseOfTheEndpoint) {
  EXPECT_THAT(control_names("127.0.0.1:29470"), ElementsAre("127.0.0.1:29470"));
  EXPECT_THAT(control_names("[::1]:29470"), ElementsAre("[::1]:29470"));
  EXPECT_THAT(control_names("[0:0::1]:29470"), ElementsAre("[::1]:29470"));
  EXPECT_THAT(control_names("[::ffff:127.0.0.2]:29470"), ElementsAre("127.0.0.2:29470"));
  EXPECT_THAT(control_names("LOCALHOST:29470"), testing::Contains("127.0.0.1:29470"));
}

TEST(ControlNames, FollowTheFileOfASocket) {
  const std::string file = testing::TempDir() + "control-names-" + std::to_string(getpid());
  const std::string link = file + "-link";
  std::ofstream(file).put('x');
  std::filesystem::create_hard_link(file, link);
  const auto names = control_names("unix:" + file);
  ASSERT_EQ(names.size(), 2U);
  EXPECT_EQ(control_names("unix://" + file), names);
  EXPECT_EQ(control_names("unix:" + link).front(), names.front());
  std::filesystem::remove(link);
  std::filesystem::remove(file);
  EXPECT_THAT(control_names("unix:" + file), ElementsAre(names.back())) << "the path is left";
}

TEST(ControlNames, LongOnesAreHashedNotCut) {
  const std::string long_name(200, 'a');
  EXPECT_EQ(control_file("127.0.0.1:29470"), "127.0.0.1:29470");
  EXPECT_EQ(control_file(long_name).size(), 16U);
  EXPECT_NE(control_file(long_name), control_file(long_name + "b"));
  for (const char* odd : {"", "..", "a/b", "a b", "a\nb"}) {
    EXPECT_EQ(control_file(odd).size(), 16U) << odd;
  }
}

}  // namespace
