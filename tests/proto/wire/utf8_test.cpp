#include "haptic/wire/utf8.hpp"

#include <gtest/gtest.h>

#include <iconv.h>

#include <random>
#include <string>

namespace haptic::wire {
namespace {

/// The C library's own decoder has the last word, over random bytes near the borders of the rules.
TEST(Utf8, AgreesWithIconvOnRandomBytes) {
  const iconv_t decoder = iconv_open("UTF-32LE", "UTF-8");
  ASSERT_NE(decoder, reinterpret_cast<iconv_t>(-1));
  constexpr unsigned char kBytes[] = {0x00, 0x41, 0x7F, 0x80, 0x8F, 0x90, 0x9F, 0xA0, 0xBF,
                                      0xC0, 0xC1, 0xC2, 0xDF, 0xE0, 0xE1, 0xEC, 0xED, 0xEE,
                                      0xEF, 0xF0, 0xF1, 0xF3, 0xF4, 0xF5, 0xFF};
  std::mt19937 random(7);
  std::uniform_int_distribution<std::size_t> any(0, std::size(kBytes) - 1);
  std::uniform_int_distribution<std::size_t> length(0, 5);
  int good = 0;
  for (int trial = 0; trial < 200'000; ++trial) {
    std::string text(length(random), ' ');
    for (char& c : text) c = static_cast<char>(kBytes[any(random)]);
    std::string bytes = text;
    char* in = bytes.data();
    std::size_t in_left = bytes.size();
    char out[64];
    char* to = out;
    std::size_t out_left = sizeof(out);
    iconv(decoder, nullptr, nullptr, nullptr, nullptr);
    const bool decoded =
        iconv(decoder, &in, &in_left, &to, &out_left) != static_cast<std::size_t>(-1);
    ASSERT_EQ(is_utf8(text), decoded) << "trial " << trial;
    good += decoded ? 1 : 0;
  }
  EXPECT_GT(good, 20'000);
  iconv_close(decoder);
}

}  // namespace
}  // namespace haptic::wire
