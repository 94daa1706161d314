#include "server/base/log.hpp"

#include <gtest/gtest.h>
#include <spdlog/details/log_msg.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>

namespace haptic::server {
namespace {

std::string formatted(const std::string& text, LogFormat format, bool for_journal = false,
                      spdlog::level::level_enum level = spdlog::level::warn) {
  spdlog::memory_buf_t line;
  log_formatter(format, for_journal)->format({"hapticd", level, text}, line);
  return {line.data(), line.size()};
}

const std::string kTime = R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}[+-]\d\d:\d\d)";

TEST(LogFormat, TextHasDateZoneAndLevel) {
  const std::string line = formatted("finger: LOST", LogFormat::kText);
  EXPECT_TRUE(std::regex_match(line, std::regex(kTime + " warning finger: LOST\n"))) << line;
}

TEST(LogFormat, JsonHoldsAnyMessageUnchanged) {
  // A person may read it, too: only ASCII, the rest as \u....
  for (const std::string text :
       {"finger: LOST", "a \"quoted\"\\ name\n\x01", "\xC3\xA9", "a\u009b2J\u202eb\u2028c\x7f"}) {
    const std::string line = formatted(text, LogFormat::kJson);
    const auto entry = nlohmann::json::parse(line);
    EXPECT_EQ(entry["message"], text);
    EXPECT_EQ(entry["level"], "warning");
    EXPECT_TRUE(std::regex_match(entry["time"].get<std::string>(), std::regex(kTime)));
    EXPECT_EQ(line.find('\n'), line.size() - 1);
    for (const char c : line) EXPECT_TRUE(c == '\n' || (c >= 0x20 && c < 0x7F)) << line;
  }
}

TEST(LogFormat, InvalidUtf8StaysValidJson) {
  const auto entry = nlohmann::json::parse(formatted("a\xFFz", LogFormat::kJson));
  EXPECT_EQ(entry["message"], "a\xEF\xBF\xBDz");  // U+FFFD
}

TEST(LogFormat, OnlyWhatShowsItselfIsShown) {
  const std::pair<const char*, const char*> rows[] = {{"\u0080", "\\xc2\\x80"},
                                                      {"\u009f", "\\xc2\\x9f"},
                                                      {"\u00a0", "\u00a0"},
                                                      {"\u061c", "\\xd8\\x9c"},
                                                      {"\u200e", "\\xe2\\x80\\x8e"},
                                                      {"\u200f", "\\xe2\\x80\\x8f"},
                                                      {"\u2028", "\\xe2\\x80\\xa8"},
                                                      {"\u2029", "\\xe2\\x80\\xa9"},
                                                      {"\u202a", "\\xe2\\x80\\xaa"},
                                                      {"\u2066", "\\xe2\\x81\\xa6"},
                                                      {"\u2069", "\\xe2\\x81\\xa9"},
                                                      {"\u206a", "\u206a"},
                                                      {"\x9b"
                                                       "2J",
                                                       "\\x9b2J"},
                                                      {"\xe2\x80", "\\xe2\\x80"},
                                                      {"\xc2"
                                                       "A",
                                                       "\\xc2"
                                                       "A"},
                                                      {"\xf0\x9f\x98\x80", "\xf0\x9f\x98\x80"},
                                                      {"\x7f", "\\x7f"},
                                                      {"a\nb\x1b[2J", "a\\x0ab\\x1b[2J"},
                                                      {"\xff", "\\xff"}};
  for (const auto& [text, shown] : rows) {
    const std::string line = formatted(std::string("<") + text + ">", LogFormat::kText);
    EXPECT_NE(line.find("<" + std::string(shown) + ">\n"), std::string::npos) << line;
  }
}

TEST(LogFormat, JournalLinesBeginWithTheirPriority) {
  using spdlog::level::level_enum;
  for (const auto& [level, priority] :
       {std::pair{level_enum::critical, "<2>"}, std::pair{level_enum::err, "<3>"},
        std::pair{level_enum::warn, "<4>"}, std::pair{level_enum::info, "<6>"},
        std::pair{level_enum::debug, "<7>"}}) {
    for (const LogFormat format : {LogFormat::kText, LogFormat::kJson}) {
      EXPECT_EQ(formatted("x", format, true, level).substr(0, 3), priority);
    }
  }
}

TEST(LogFormat, JournalStreamMustBeStandardError) {
  struct stat status {};
  ASSERT_EQ(fstat(STDERR_FILENO, &status), 0);
  const std::string device = std::to_string(status.st_dev) + ":";
  setenv("JOURNAL_STREAM", (device + std::to_string(status.st_ino)).c_str(), 1);
  EXPECT_TRUE(stderr_is_journal());
  setenv("JOURNAL_STREAM", (device + std::to_string(status.st_ino + 1)).c_str(), 1);
  EXPECT_FALSE(stderr_is_journal());
  unsetenv("JOURNAL_STREAM");
  EXPECT_FALSE(stderr_is_journal());
}

}  // namespace
}  // namespace haptic::server
