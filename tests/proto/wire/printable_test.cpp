#include "haptic/wire/printable.hpp"

#include <gtest/gtest.h>

namespace {

using haptic::wire::printable;

TEST(Printable, LeavesReadableText) {
  EXPECT_EQ(printable("finger \\ 1 \xC3\xA9 \xE6\x89\x8B"), "finger \\ 1 \xC3\xA9 \xE6\x89\x8B");
}

TEST(Printable, EscapesWhatMovesATerminal) {
  EXPECT_EQ(printable("\x1b[2J\a\r\n"), "\\x1b[2J\\x07\\x0d\\x0a");
  EXPECT_EQ(printable("\xC2\x9B"), "\\xc2\\x9b") << "C1";
  EXPECT_EQ(printable("a\xE2\x80\xAE"
                      "b"),
            "a\\xe2\\x80\\xaeb")
      << "writing direction";
}

TEST(Printable, EscapesWhatIsNoText) {
  EXPECT_EQ(printable("\xFF\x9B"), "\\xff\\x9b");
  EXPECT_EQ(printable("\xE0\x82\x9B"), "\\xe0\\x82\\x9b") << "a long form of C1";
  EXPECT_EQ(printable("\xED\xA0\x80"), "\\xed\\xa0\\x80") << "a surrogate";
  EXPECT_EQ(printable("\xE2\x80"), "\\xe2\\x80") << "cut";
}

TEST(Printable, IsTheSameIfDoneTwice) {
  const std::string once = printable("\x1b\n\xFF");
  EXPECT_EQ(printable(once), once);
}

}  // namespace
