#include "server/front/net/tls_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace {

using haptic::server::ending;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::StartsWith;

TEST(CertificateEnd, IsToldTwoWeeksBefore) {
  constexpr std::time_t kEnd = 1'000'000'000, kDay = 86'400;  // 2001-09-09 01:46:40 UTC
  const std::vector<haptic::server::CertificateEnd> ends{{"key = 'a'", kEnd}};
  EXPECT_THAT(ending(ends, kEnd - 15 * kDay), IsEmpty());
  EXPECT_THAT(ending(ends, kEnd - 3 * kDay),
              ElementsAre(StartsWith("key = 'a': expires on 2001-09-09 01:46 UTC, in 3 days")));
  EXPECT_THAT(ending(ends, kEnd + 1),
              ElementsAre(StartsWith("key = 'a': has expired on 2001-09-09 01:46 UTC")));
}

}  // namespace
