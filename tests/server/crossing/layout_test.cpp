// Layouts, which two builds compare before they share memory.
#include "server/crossing/link_messages.hpp"

#include <gtest/gtest.h>

#include <string>

namespace haptic::server {
namespace {

namespace told {
struct Gains {
  double elastic{0.0};
  double damping{0.0};
};
struct Outer {
  Gains gains{};
  Maybe<Gains> other{};
};
}  // namespace told

namespace swapped {
struct Gains {
  double damping{0.0};
  double elastic{0.0};
};
struct Outer {
  Gains gains{};
  Maybe<Gains> other{};
};
}  // namespace swapped

namespace retyped {
struct Gains {
  double elastic{0.0};
  std::int64_t damping{0};
};
}  // namespace retyped

namespace moved {
struct Gains {
  std::uint8_t first{0};
  double elastic{0.0};
};
}  // namespace moved

/// "name@offset " of each.
template <typename T>
std::string fields() {
  std::string all;
  T value{};
  for_each_field(value, [&](std::string_view name, const auto& field) {
    all += std::string(name) + '@' +
           std::to_string(reinterpret_cast<const char*>(&field) -
                          reinterpret_cast<const char*>(&value)) +
           ' ';
  });
  return all;
}

TEST(Layout, FieldsHaveTheirNamesAndPlaces) {
  EXPECT_EQ(fields<told::Gains>(), "elastic@0 damping@8 ");
  EXPECT_EQ(fields<swapped::Gains>(), "damping@0 elastic@8 ");
  EXPECT_EQ(fields<moved::Gains>(), "first@0 elastic@8 ");
  EXPECT_EQ(fields<SerialisedState>().substr(0, 24), "size@0 tenure@4 tick@8 n");
}

TEST(Layout, TwoSwappedDoublesChangeIt) {
  // The types' own names are left out, as if both builds called the struct the same.
  EXPECT_NE(layout_of_fields<told::Gains>(), layout_of_fields<swapped::Gains>());
  EXPECT_NE(layout_of_fields<told::Gains>(), layout_of_fields<retyped::Gains>());
  EXPECT_NE(layout_of_fields<told::Gains>(), layout_of_fields<moved::Gains>());
  EXPECT_EQ(layout_of_fields<told::Gains>(), layout_of_fields<told::Gains>());
}

namespace told {
enum class Kind : std::uint8_t { kStop, kClear };
}
namespace swapped {
enum class Kind : std::uint8_t { kClear, kStop };
}
namespace grown {
enum class Kind : std::uint8_t { kStop, kRelease, kClear };
}

TEST(Layout, ValuesOfAnEnumerationChangeIt) {
  EXPECT_EQ(value_name<told::Kind::kClear>(), "kClear");
  EXPECT_NE(layout_of_values<told::Kind>(), layout_of_values<swapped::Kind>());
  EXPECT_NE(layout_of_values<told::Kind>(), layout_of_values<grown::Kind>());
  EXPECT_EQ(layout_of_values<told::Kind>(), layout_of_values<told::Kind>());
}

TEST(Layout, ReachesWhatAValueHolds) {
  EXPECT_NE(layout<std::vector<told::Gains>>(), layout<std::vector<swapped::Gains>>());
  EXPECT_NE(layout<Maybe<told::Gains>>(), layout<Maybe<swapped::Gains>>());
  EXPECT_NE(layout_of_fields<told::Outer>(), layout_of_fields<swapped::Outer>());
  EXPECT_NE(layout<ProxySample>(), layout<PoseSample>());
}

TEST(Layout, BoolsAndOptionalsMustNotCross) {
  struct Bool {
    bool engaged{false};
  };
  struct Optional {
    std::optional<double> gain{};
  };
  struct Fine {
    Flag engaged{};
    Maybe<double> gain{};
    std::array<told::Gains, 2> gains{};
  };
  EXPECT_FALSE(any_bits<Bool>());
  EXPECT_FALSE(any_bits<Optional>());
  EXPECT_FALSE(any_bits<std::string>());
  EXPECT_TRUE(any_bits<Fine>());
  EXPECT_FALSE(any_bits<Answer>()) << "the owner's own, with an optional";
  EXPECT_TRUE(any_bits<FrontMessage>());
}

}  // namespace
}  // namespace haptic::server
