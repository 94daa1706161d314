#include "hw/motion/motion_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "haptic/core/error.hpp"
#include "tests/support/message_of.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::hw {
namespace {

using test::TemporaryFile;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

MotionTable read(const TemporaryFile& file) {
  return read_motion_csv(file.path(), {{"l_x", "q_B"}, joint_angle_columns()});
}

std::string error_of(std::string_view text) {
  const TemporaryFile file(text);
  return test::message_of<core::DeviceError>([&] { return read(file); });
}

TEST(MotionCsv, ColumnsMayHaveAnyOrder) {
  const TemporaryFile file(
      "note,q_o2_pip_rad,time_s,q_o1_mcp_rad\n"
      "first,0.2,5.0,0.1\n"
      ",0.4,5.5,+0.3\n");
  const MotionTable table = read(file);
  EXPECT_EQ(table.alternative, 1u);
  EXPECT_THAT(table.time_s, ElementsAre(0.0, 0.5));
  EXPECT_THAT(table.values[0], ElementsAre(0.1, 0.3));
  EXPECT_THAT(table.values[1], ElementsAre(0.2, 0.4));
  EXPECT_THAT(table.line, ElementsAre(2u, 3u));
}

TEST(MotionCsv, TheFirstAlternativeWins) {
  const TemporaryFile file(
      "time_s,q_o1_mcp_rad,q_o2_pip_rad,l_x,q_B\n0,1,2,0.01,0.1\n1,1,2,0.02,0.2\n");
  const MotionTable table = read(file);
  EXPECT_EQ(table.alternative, 0u);
  EXPECT_THAT(table.values[0], ElementsAre(0.01, 0.02));
}

TEST(MotionCsv, AcceptsWindowsFiles) {
  const TemporaryFile file("\xEF\xBB\xBFtime_s, l_x ,q_B\r\n0,1,2\r\n1, 3 ,4e-1\r\n\r\n\r\n");
  const MotionTable table = read(file);
  EXPECT_THAT(table.values[0], ElementsAre(1.0, 3.0));
  EXPECT_THAT(table.values[1], ElementsAre(2.0, 0.4));
}

TEST(MotionCsv, ReadsWhatSpreadsheetsWrite) {
  for (const char* text :
       {"time_s;l_x;q_B\n0;1;2\n0.1;3;4\n", "time_s\tl_x\tq_B\n0\t1\t2\n0.1\t3\t4\n",
        "# time_s,l_x,q_B\n0,1,2\n0.1,3,4\n", "time_s,l_x,q_B,,\n0,1,2,,\n0.1,3,4,,,,\n",
        "\"\",\"time_s\",\"l_x\",'q_B'\n\"1\",0,1,2\n\"2\",0.1,\"3\",4\n"}) {
    const TemporaryFile file(text);
    const MotionTable table = read(file);
    EXPECT_THAT(table.values[0], ElementsAre(1.0, 3.0)) << text;
    EXPECT_THAT(table.values[1], ElementsAre(2.0, 4.0)) << text;
    EXPECT_THAT(table.doubts, testing::IsEmpty()) << text;
  }
}

TEST(MotionCsv, NamesAnotherFormat) {
  const std::string commas =
      "motion.csv:2: 6 values in a line of 3 columns: decimal commas? Numbers must have a decimal "
      "point, and each column a name in the header";
  const std::string point = "must be a finite number with a decimal point, not a comma";
  for (const auto& [text, sentence] : std::initializer_list<std::pair<std::string, std::string>>{
           {"time_s,l_x,q_B\n0,0,1,1,2,2\n", commas},
           {"time_s,l_x,q_B\n\"0,0\",\"1,1\",\"2,2\"\n", commas},
           {"time_s,l_x,q_B\n1,0,1,2\n", "motion.csv:2: 4 values in a line of 3 columns"},
           {"time_s;l_x;q_B\n0,5;1;2\n", "motion.csv:2: column time_s = '0,5': " + point},
           {"time_s;l_x;q_B\n0;1.000,5;2\n", "motion.csv:2: column l_x = '1.000,5': " + point},
           {"time_s l_x q_B\n0 1 2\n", ", with commas, semicolons or tabs between them"},
           {"time_s,l_x,q_B\r0,1,2\r", "motion.csv: its lines end with CR; must end with LF"},
           {std::string("\xFF\xFEt\0i\0m\0e\0", 10),
            "motion.csv: is UTF-16; must be saved as UTF-8"},
           {std::string("PK\3\4\0\0", 6), "motion.csv: is no text; must be saved as CSV"},
           {"time_s,l_x,q_B\n1.6e18,1,2\n",
            "column time_s = '1.6e18': must lie within +-9e9 s (ms, us or ns?)"}}) {
    EXPECT_THAT(error_of(text), HasSubstr(sentence)) << text;
  }
}

TEST(MotionCsv, DoubtsOtherUnits) {
  const auto doubts = [](const std::string& rows) {
    const TemporaryFile file("time_s,q_o1_mcp_rad,q_o2_pip_rad\n" + rows);
    return read(file).doubts;
  };
  const auto says = [](const std::string& sentence) {
    return HasSubstr("motion.csv: " + sentence);
  };
  const std::string range = ": degrees? a finger's joints bend by -1 to 2.2 rad";
  EXPECT_THAT(doubts("0,20,0.3\n0.01,54.3,0.3\n"),
              ElementsAre(says("column q_o1_mcp_rad: values to 54.3" + range)));
  EXPECT_THAT(doubts("0,0.2,-30\n0.01,0.2,1\n"),
              ElementsAre(says("column q_o2_pip_rad: values to -30" + range)));
  for (const char* unit : {"0,0,0\n10,0,0\n20,0,0\n", "0,0,0\n10000,0,0\n20000,0,0\n"}) {
    EXPECT_THAT(doubts(unit), ElementsAre(says("column time_s: 3 rows in 2"))) << unit;
    EXPECT_THAT(doubts(unit).front(), HasSubstr(" s: milliseconds or microseconds? must be in s"));
  }
  EXPECT_THAT(doubts("0,-0.9,2.1\n0.45,0,0\n"), testing::IsEmpty());
}

TEST(MotionCsv, SaysWhatIsWrongAndWhere) {
  const std::string begin = "time_s,l_x,q_B\n";
  const std::pair<std::string, std::vector<std::string>> table[] = {
      {"time_s,q_o1_mcp_rad,other\n0,1,2\n1,2,3\n",
       {"motion.csv:1", "missing: q_o2_pip_rad", "found: time_s, q_o1_mcp_rad, other", "l_x"}},
      {"time_s,l_x,q_B,l_x\n0,1,2,3\n1,1,2,3\n", {"l_x stands twice"}},
      {begin + "0,1,2\n1,2\n", {"motion.csv:3", "column q_B", "2 value(s)"}},
      {begin + "0,1,2\n0,1,2\n", {"motion.csv:3", "time_s", "later"}},
      {begin + "0,1,2\n-3,1,2\n", {"motion.csv:3", "time_s", "later"}},
      {begin + "1e300,1,2\n2e300,1,2\n", {"9e9"}},
      {begin + "-8e9,1,2\n8e9,1,2\n",
       {"motion.csv:3", "time_s = '8e9'", "at most 9e9 s after the first row"}},
      {begin, {"0 row(s)"}},
      {begin + "0,1,2", {"1 row(s)"}},
      {"", {"is empty"}}};
  for (const auto& [text, parts] : table) {
    for (const std::string& part : parts) EXPECT_THAT(error_of(text), HasSubstr(part)) << text;
  }
}

TEST(MotionCsv, NamesTheNonNumericValue) {
  const std::string start = "time_s,l_x,q_B\n0,1,2\n";
  for (const char* value :
       {"abc", "1.5x", "", "nan", "inf", "-inf", "1e999", "0x10", "+-1", "1 2"}) {
    EXPECT_THAT(error_of(start + "1,2," + value + "\n"),
                AllOf(HasSubstr("motion.csv:3"), HasSubstr("column q_B"),
                      HasSubstr("'" + std::string(value) + "'"), HasSubstr("finite number")))
        << value;
  }
  EXPECT_THAT(error_of(start + "1,2,\x1b[2J" + '\0' + std::string(1000, 'x') + "\n"),
              HasSubstr("'\x1b[2J?" + std::string(55, 'x') + "...': must be a finite number"));
}

TEST(MotionCsv, SpanFitsAClockOfNanoseconds) {
  const TemporaryFile longest("time_s,l_x,q_B\n-8e9,1,2\n1e9,1,2\n");
  EXPECT_EQ(read(longest).time_s.back(), 9e9);
}

TEST(MotionCsv, NamesAnUnreadableFile) {
  const auto message = [](const std::filesystem::path& path) {
    return test::message_of<core::DeviceError>(
        [&] { return read_motion_csv(path, {joint_angle_columns()}); });
  };
  EXPECT_THAT(message("no/such/file.csv"),
              AllOf(HasSubstr("no/such/file.csv"), HasSubstr("cannot be read")));
  EXPECT_THAT(message(testing::TempDir()), HasSubstr("cannot be read"));
  EXPECT_THAT(message("/dev/null"), HasSubstr("cannot be read")) << "a device may never end";
}

TEST(MotionCsv, RefusesAHugeFileUnread) {
  const TemporaryFile file("time_s,l_x,q_B\n0,1,2\n1,1,2\n");
  std::filesystem::resize_file(file.path(), (std::uintmax_t{256} << 20U) + 1);  // a hole at its end
  EXPECT_THAT(test::message_of<core::DeviceError>([&] { return read(file); }),
              AllOf(HasSubstr("motion.csv: has 268435457 bytes"), HasSubstr("at most 268435456")));
}

TEST(ShippedMotion, OpensAndClosesLikeAHand) {
  const MotionTable table = read_motion_csv(
      HAPTIC_SOURCE_DIR "/server/scenes/motion/reach_and_grasp.csv", {joint_angle_columns()});
  EXPECT_EQ(table.time_s.back(), 20.0);
  const std::vector<double>& mcp = table.values[0];
  const auto [open, closed] = std::minmax_element(mcp.begin(), mcp.end());
  EXPECT_GT(*open, -0.02);
  EXPECT_LT(*open, 0.15);
  EXPECT_GT(*closed, 0.7);
  EXPECT_LT(*closed, 1.05);
  for (const std::vector<double>& joint : table.values) {
    EXPECT_NEAR(joint.front(), joint.back(), 0.05) << "it repeats without a jump";
    for (std::size_t i = 1; i < joint.size(); ++i) {
      const double dt = table.time_s[i] - table.time_s[i - 1];
      EXPECT_LT(std::abs(joint[i] - joint[i - 1]) / dt, 8.0);  // rad/s
    }
  }
}

TEST(MotionCsv, FiftyMillisecondsAreNoGap) {
  for (int i = 0; i < 2000; ++i) {
    const double t = 0.05 * i;
    EXPECT_FALSE(is_gap(t, 0.05 * (i + 1))) << i;
    EXPECT_TRUE(is_gap(t, t + 0.050001)) << i;
  }
}

}  // namespace
}  // namespace haptic::hw
