/// Contacts from a simulation's geometry: what is refused. Their numbers are in the shared vectors
/// (contact_vectors_test.cpp).

#include "haptic/client/contact.hpp"

#include <gtest/gtest.h>

#include "round_trip.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::client {
namespace {

using std::chrono::milliseconds;

TEST(PointMap, RefusesAPhalanxBeyondX) {
  const std::vector<double> x{0.5, 0.7};
  EXPECT_THROW(static_cast<void>(point_on_finger({0.045}, x, 2, 0.0)), std::out_of_range);
}

TEST(ContactAt, RefusesCoordinatesBeyondX) {
  Contact contact{.point = point_itself({0.0, 0.0, 0.0, 0.0}, 1), .normal = {1.0, 0.0, 0.0}};
  const auto refusal = [&](const std::vector<double>& x) {
    return test::message_of<std::out_of_range>([&] { return contact_at(x, contact, 1500.0); });
  };
  EXPECT_EQ(refusal({0, 0, 0, 0}), "no error");
  EXPECT_EQ(refusal({0, 0, 0}),
            "point.first_coordinate 1, 3 coordinates: must lie within the 3 of x");
  contact.point.first_coordinate = 9;
  EXPECT_NE(refusal({0, 0, 0, 0}), "no error");
  contact.point.first_coordinate = 1;
  contact.point.second.resize(5);
  EXPECT_EQ(refusal({0, 0, 0, 0}),
            "point.second: has 5 vectors, must have 0 or 6 for 3 coordinates");
}

TEST(RoundTripTime, RisesAtOnceFallsSlowly) {
  RoundTrip trip;
  const RoundTrip::TimePoint begin{};
  trip.used(1, begin);
  EXPECT_EQ(trip.value().count(), 0) << "nothing was published";
  const auto takes = [&](std::uint64_t seq, milliseconds time) {
    trip.published(seq, begin);
    trip.used(seq, begin + time);
    trip.used(seq, begin + 2 * time);  // a later state with the same sample
    return trip.value();
  };
  EXPECT_EQ(takes(2, milliseconds(16)), milliseconds(16));
  EXPECT_EQ(takes(3, milliseconds(48)), milliseconds(48));
  EXPECT_EQ(takes(4, milliseconds(16)), milliseconds(46));
}

}  // namespace
}  // namespace haptic::client
