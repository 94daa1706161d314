#include "tests/server/owner/ingress/ingress_fixture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic::server {
namespace {

using core::Duration;
using core::TimePoint;

TEST_F(IngressTest, AnAcceptedSampleReachesTheMailbox) {
  EXPECT_EQ(send({0.25, -0.5}, t0), IngressVerdict::kAccepted);
  EXPECT_EQ(newest().seq, 1U);
  EXPECT_EQ(newest().tenure, 1U);
  EXPECT_EQ(newest().born, t0);
  ASSERT_EQ(newest().x.size(), 2);
  EXPECT_EQ(newest().x[0], 0.25);
  EXPECT_EQ(newest().x[1], -0.5);
}

TEST_F(IngressTest, AcceptsNothingWithoutALease) {
  ingress.end_lease();
  EXPECT_EQ(send({0, 0}, t0), IngressVerdict::kOldEpoch);
  EXPECT_EQ(ingress.counters()[IngressVerdict::kOldEpoch], 1U);
}

TEST_F(IngressTest, SourceTimeOnlyAgesASample) {
  const auto born_of = [&](Duration left_before, TimePoint at) {
    ProxySample sample{.epoch = epoch,
                       .seq = ++seq,
                       .arrival = at,
                       .left = server::Departure{at - left_before, at - left_before},
                       .mode = core::ProxyMode::kHeld,
                       .position = {0.0, 0.0}};
    EXPECT_EQ(judge(sample), IngressVerdict::kAccepted);
    return newest().born;
  };
  EXPECT_EQ(born_of(40ms, t0), t0 - 40ms);
  EXPECT_EQ(born_of(-5ms, t0 + 16ms), t0 + 16ms);
  EXPECT_EQ(ingress.last_accepted(), t0 + 16ms) << "the lease's clock counts arrivals";
}

TEST_F(IngressTest, ContactsCountFromTheirSourceTime) {
  const auto computed_of = [&](std::optional<Duration> before, TimePoint at) {
    ProxySample sample{.epoch = epoch,
                       .seq = ++seq,
                       .arrival = at,
                       .mode = core::ProxyMode::kHeld,
                       .position = {0.0, 0.0}};
    if (before) sample.left = server::Departure{at - *before, at - 10ms};
    EXPECT_EQ(judge(sample), IngressVerdict::kAccepted);
    EXPECT_EQ(newest().born, before ? at - 10ms : at) << "freshness does not believe an estimate";
    return newest().computed;
  };
  EXPECT_EQ(computed_of(50ms, t0), t0 - 50ms);
  EXPECT_EQ(computed_of(-1h, t0 + 16ms), t0 + 16ms) << "not later than it came";
  EXPECT_EQ(computed_of({}, t0 + 32ms), t0 + 32ms);
}

TEST_F(IngressTest, RenewedLeaseContinuesUnderAnotherEpoch) {
  EXPECT_EQ(send({0, 0}, t0), IngressVerdict::kAccepted);
  ingress.renew_lease(7);
  EXPECT_EQ(send({0, 0}, t0 + 16ms), IngressVerdict::kOldEpoch);
  epoch = 7;
  EXPECT_EQ(send({0, 0}, t0 + 32ms), IngressVerdict::kAccepted);
  EXPECT_EQ(newest().tenure, 1U) << "to the loop it is the same lease";
  EXPECT_EQ(newest().gapless_samples, 2U);
  EXPECT_EQ(ingress.counters()[IngressVerdict::kAccepted], 2U);
  EXPECT_EQ(ingress.newest_seq(), seq);
}

TEST_F(IngressTest, RemembersTheCarrierOf256Samples) {
  for (int i = 0; i < 300; ++i) send({0, 0}, t0 + i * 16ms);
  EXPECT_EQ(ingress.carrier_of(300, t0 + 299 * 16ms), Carrier::kGrpc);
  EXPECT_EQ(ingress.carrier_of(45, t0 + 44 * 16ms), Carrier::kGrpc);
  EXPECT_EQ(ingress.carrier_of(44, t0 + 43 * 16ms), Carrier::kNone) << "too long ago";
  EXPECT_EQ(ingress.carrier_of(300, t0), Carrier::kNone) << "of another lease";
}

TEST_F(IngressTest, RefusesSamplesOfAnOlderLease) {
  ingress.begin_lease(2, 60.0, 100ms);
  seq = 1000;
  EXPECT_EQ(send({0, 0}, t0), IngressVerdict::kOldEpoch);
  EXPECT_NE(why.find("epoch"), std::string::npos);
}

TEST_F(IngressTest, NewLeaseResetsSequenceAndProxy) {
  seq = 99;
  EXPECT_EQ(send({1, 1}, t0), IngressVerdict::kAccepted);
  ingress.begin_lease(2, 60.0, 100ms);
  EXPECT_EQ(newest().mode, core::ProxyMode::kNone);
  EXPECT_EQ(newest().tenure, 2U);
  EXPECT_EQ(ingress.last_accepted(), TimePoint{});
  epoch = 2;
  seq = 0;
  EXPECT_EQ(send({1, 1}, t0 + 1s), IngressVerdict::kAccepted);
}

TEST_F(IngressTest, RefusesANonRisingSequence) {
  send({1, 1}, t0);
  seq = 0;
  EXPECT_EQ(send({2, 2}, t0 + 20ms), IngressVerdict::kOldSequence);
  EXPECT_EQ(newest().x[0], 1.0);
  EXPECT_EQ(newest().born, t0);
  EXPECT_EQ(ingress.last_accepted(), t0);
  EXPECT_NE(why.find("seq = 1"), std::string::npos);
}

TEST_F(IngressTest, RejectionNamesFieldValueAndAllowed) {
  EXPECT_EQ(send({1, 2, 3}, t0), IngressVerdict::kWrongSize);
  EXPECT_EQ(why, "position has 3 values: must have 2, one per virtual coordinate");
  EXPECT_EQ(send({0, std::nan("")}, t0), IngressVerdict::kNotFinite);
  EXPECT_NE(why.find("position[1]"), std::string::npos);
  EXPECT_EQ(send({-std::numeric_limits<double>::infinity(), 0}, t0), IngressVerdict::kNotFinite);
  EXPECT_EQ(send({0, -1000.5}, t0), IngressVerdict::kOutOfBounds);
  EXPECT_NE(why.find("-1000.5"), std::string::npos);
  EXPECT_EQ(send({0, 0}, t0, core::ProxyMode::kNone), IngressVerdict::kUnknownMode);
  EXPECT_EQ(send({}, t0), IngressVerdict::kWrongSize);
  EXPECT_EQ(send({}, t0, core::ProxyMode::kPlanes), IngressVerdict::kWrongSize);
  const IngressCounters counters = ingress.counters();
  EXPECT_EQ(counters[IngressVerdict::kWrongSize], 3U);
  EXPECT_EQ(counters[IngressVerdict::kNotFinite], 2U);
  EXPECT_EQ(counters[IngressVerdict::kOutOfBounds], 1U);
  EXPECT_EQ(counters[IngressVerdict::kUnknownMode], 1U);
  EXPECT_EQ(counters[IngressVerdict::kAccepted], 0U);
  EXPECT_FALSE(mailbox.take() && mailbox.value().mode != core::ProxyMode::kNone);
  EXPECT_EQ(send({1000.0, -1000.0}, t0), IngressVerdict::kAccepted) << "the bound itself";
}

TEST_F(IngressTest, FreeModeNeedsNoPosition) {
  EXPECT_EQ(send({}, t0, core::ProxyMode::kFree), IngressVerdict::kAccepted);
  EXPECT_EQ(newest().mode, core::ProxyMode::kFree);
}

TEST_F(IngressTest, SubnormalCoordinatesBecomeZero) {
  send({std::numeric_limits<double>::denorm_min(), -std::numeric_limits<double>::min() / 2}, t0);
  EXPECT_EQ(newest().x[0], 0.0);
  EXPECT_EQ(newest().x[1], 0.0);
  send({std::numeric_limits<double>::min(), -0.0}, t0 + 20ms);
  EXPECT_EQ(newest().x[0], std::numeric_limits<double>::min());
  EXPECT_TRUE(std::signbit(newest().x[1])) << "other numbers keep their bits";
  send({-std::nextafter(std::numeric_limits<double>::min(), 0.0), -1.0}, t0 + 40ms);
  EXPECT_EQ(newest().x[0], 0.0);
  EXPECT_EQ(newest().x[1], -1.0);
}

TEST_F(IngressTest, LongGapRestartsTheStreamsHealth) {
  send({0, 0}, t0);
  send({0, 0}, t0 + 100ms);
  EXPECT_EQ(newest().gapless_since, t0);
  EXPECT_EQ(newest().gapless_samples, 2U);
  send({0, 0}, t0 + 200ms + 1ns);
  EXPECT_EQ(newest().gapless_since, t0 + 200ms + 1ns);
  EXPECT_EQ(newest().gapless_samples, 1U);
}

/// Planes of two coordinates; the last value of a row is the offset.
class IngressPlanesTest : public IngressTest {
 protected:
  IngressVerdict send_planes(const std::vector<std::vector<double>>& rows,
                             core::ProxyMode mode = core::ProxyMode::kPlanes) {
    ProxySample sample{.epoch = epoch,
                       .seq = ++seq,
                       .arrival = t0,
                       .mode = mode,
                       .plane_count = static_cast<std::uint32_t>(rows.size()),
                       .position = {0.25, -0.5}};
    for (std::size_t i = 0; i < std::min(rows.size(), sample.planes.size()); ++i) {
      sample.planes[i] = {{rows[i].data(), rows[i].size() - 1}, rows[i].back()};
    }
    return judge(sample);
  }
};

TEST_F(IngressPlanesTest, PlanesReachTheMailboxAsColumns) {
  EXPECT_EQ(send_planes({{1, 2, 3}, {-4, 5e-320, 6}}), IngressVerdict::kAccepted);
  EXPECT_EQ(newest().mode, core::ProxyMode::kPlanes);
  const core::PlaneSet& planes = newest().planes;
  ASSERT_EQ(planes.size(), 2);
  ASSERT_EQ(planes.normals.rows(), 2);
  EXPECT_EQ(planes.normals(1, 0), 2.0);
  EXPECT_EQ(planes.normals(0, 1), -4.0);
  EXPECT_EQ(planes.normals(1, 1), 0.0) << "subnormal numbers become 0";
  EXPECT_EQ(planes.offsets[1], 6.0);
  EXPECT_EQ(newest().x[0], 0.25);
  EXPECT_EQ(send_planes({32, {1, 2, 3}}), IngressVerdict::kAccepted);
  EXPECT_EQ(newest().planes.size(), 32);
  EXPECT_EQ(newest().planes.offsets[31], 3.0);
  EXPECT_EQ(send_planes({}), IngressVerdict::kBacklog) << "the third of one moment, and used";
  EXPECT_EQ(newest().planes.size(), 0) << "free space";
}

TEST_F(IngressPlanesTest, NamesAndIgnoresAWrongPlane) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double huge = std::numeric_limits<double>::infinity();
  send_planes({{1, 2, 3}});
  const std::vector<double> good{1, 0, 0};
  EXPECT_EQ(send_planes({33, good}), IngressVerdict::kBadPlane);
  EXPECT_NE(why.find("at most 32"), std::string::npos) << why;
  EXPECT_EQ(send_planes({good, {1, 0}}), IngressVerdict::kBadPlane);
  EXPECT_NE(why.find("planes[1].normal has 1 values"), std::string::npos) << why;
  EXPECT_EQ(send_planes({{1, nan, 0}}), IngressVerdict::kBadPlane);
  EXPECT_NE(why.find("planes[0].normal[1]"), std::string::npos) << why;
  EXPECT_EQ(send_planes({{1.1e6, 0, 0}}), IngressVerdict::kBadPlane);
  EXPECT_EQ(send_planes({{0, 0, 1}}), IngressVerdict::kBadPlane);
  EXPECT_NE(why.find("direction"), std::string::npos) << why;
  EXPECT_EQ(send_planes({{1, 0, huge}}), IngressVerdict::kBadPlane);
  EXPECT_EQ(send_planes({good}, core::ProxyMode::kHeld), IngressVerdict::kBadPlane);
  EXPECT_EQ(ingress.counters()[IngressVerdict::kBadPlane], 7U);
  EXPECT_EQ(newest().planes.offsets[0], 3.0);
  EXPECT_EQ(newest().seq, 1U);
}

}  // namespace
}  // namespace haptic::server
