#include "server/ingress/ingress.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace haptic::server {
namespace {

using namespace std::chrono_literals;
using core::Duration;
using core::TimePoint;

class IngressTest : public testing::Test {
 protected:
  IngressTest() { ingress.begin_lease(1, 60.0, 100ms); }

  IngressVerdict send(std::vector<double> position, TimePoint at,
                      core::ProxyMode mode = core::ProxyMode::kHeld) {
    ProxySample sample{.epoch = epoch,
                       .seq = ++seq,
                       .arrival = at,
                       .mode = mode,
                       .position = {position.data(), position.size()}};
    return judge(sample);
  }
  IngressVerdict judge(const ProxySample& sample) {
    const Verdict verdict = ingress.accept(sample);
    why = verdict.why.str();
    return verdict.verdict;
  }
  const core::ProxySnapshot& newest() {
    mailbox.take();
    return mailbox.value();
  }

  core::Mailbox<core::ProxySnapshot> mailbox;
  Ingress ingress{mailbox, 2};
  std::uint32_t epoch{1};
  std::uint64_t seq{0};
  std::string why;
  TimePoint t0{1h};
};

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
  const IngressCounters counters = ingress.counters();
  EXPECT_EQ(counters[IngressVerdict::kWrongSize], 2U);
  EXPECT_EQ(counters[IngressVerdict::kNotFinite], 2U);
  EXPECT_EQ(counters[IngressVerdict::kOutOfBounds], 1U);
  EXPECT_EQ(counters[IngressVerdict::kUnknownMode], 1U);
  EXPECT_EQ(counters[IngressVerdict::kAccepted], 0U);
  EXPECT_FALSE(mailbox.take() && mailbox.value().mode != core::ProxyMode::kNone);
}

TEST_F(IngressTest, TheBoundItselfIsAllowed) {
  EXPECT_EQ(send({1000.0, -1000.0}, t0), IngressVerdict::kAccepted);
}

TEST_F(IngressTest, FreeModeNeedsNoPosition) {
  EXPECT_EQ(send({}, t0, core::ProxyMode::kFree), IngressVerdict::kAccepted);
  EXPECT_EQ(newest().mode, core::ProxyMode::kFree);
}

TEST_F(IngressTest, SubnormalCoordinatesBecomeZero) {
  send({std::numeric_limits<double>::denorm_min(), -std::numeric_limits<double>::min() / 2}, t0);
  EXPECT_EQ(newest().x[0], 0.0);
  EXPECT_EQ(newest().x[1], 0.0);
  send({std::numeric_limits<double>::min(), 0}, t0 + 20ms);
  EXPECT_EQ(newest().x[0], std::numeric_limits<double>::min());
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
}

TEST_F(IngressPlanesTest, ThirtyTwoPlanesAreTaken) {
  EXPECT_EQ(send_planes({32, {1, 2, 3}}), IngressVerdict::kAccepted);
  EXPECT_EQ(newest().planes.size(), 32);
  EXPECT_EQ(newest().planes.offsets[31], 3.0);
}

TEST_F(IngressPlanesTest, ZeroPlanesMeanFreeSpace) {
  send_planes({{1, 2, 3}});
  EXPECT_EQ(send_planes({}), IngressVerdict::kAccepted);
  EXPECT_EQ(newest().planes.size(), 0);
}

TEST_F(IngressPlanesTest, HeldSampleAfterPlanesHasNone) {
  send_planes({{1, 2, 3}});
  EXPECT_EQ(send({0, 0}, t0), IngressVerdict::kAccepted);
  EXPECT_EQ(newest().planes.size(), 0);
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

/// Contacts of two coordinates, x <= 1 each.
class IngressContactsTest : public IngressTest {
 protected:
  ProxySample contacts(std::uint32_t count) {
    ProxySample sample{.epoch = epoch,
                       .seq = ++seq,
                       .arrival = t0,
                       .mode = core::ProxyMode::kPlanes,
                       .plane_count = count,
                       .tick_used = 77,
                       .position = {0.25, -0.5}};
    for (std::uint32_t i = 0; i < count; ++i) sample.planes[i] = {{1.0, 0.0}, 1.0};
    return sample;
  }
  static void curve(PlaneSample& plane, std::initializer_list<double> values) {
    plane.curvature_count = static_cast<std::uint32_t>(values.size());
    std::copy(values.begin(), values.end(), plane.normal.value.begin() + 2);
  }
};

TEST_F(IngressContactsTest, LawReachesTheMailbox) {
  ProxySample sample = contacts(2);
  PlaneSample& plane = sample.planes[1];
  plane.compliance = 3.0;
  plane.velocity = -0.5;
  plane.id = 9;
  plane.mass = 2e-4;
  plane.damping = 1e-3;
  plane.ground_stiffness = 0.25;
  plane.load = -5e-320;
  curve(plane, {1.0, 5e-320, 3.0});
  EXPECT_EQ(judge(sample), IngressVerdict::kAccepted);
  const core::PlaneSet& planes = newest().planes;
  ASSERT_TRUE(planes.fits(2));
  EXPECT_EQ(planes.compliance[0], 0.0);
  EXPECT_EQ(planes.compliance[1], 3.0);
  EXPECT_EQ(planes.velocity[1], -0.5);
  EXPECT_EQ(planes.laws.col(0), Eigen::Vector4d::Zero());
  EXPECT_EQ(planes.laws.col(1), Eigen::Vector4d(2e-4, 1e-3, 0.25, 0.0));
  EXPECT_EQ(planes.curved[0], 0);
  EXPECT_EQ(planes.curved[1], 2);
  EXPECT_EQ(planes.first[1], 0);
  EXPECT_EQ(planes.curvature[0], 1.0);
  EXPECT_EQ(planes.curvature[1], 0.0) << "subnormal numbers become 0";
  EXPECT_EQ(planes.curvature[2], 3.0);
  EXPECT_EQ(newest().anchored_at, 77u);
}

TEST_F(IngressContactsTest, WithoutIdsNothingIsAnchored) {
  ProxySample sample = contacts(2);
  sample.planes[1].compliance = 3.0;
  EXPECT_EQ(judge(sample), IngressVerdict::kAccepted);
  EXPECT_EQ(newest().anchored_at, 0u);
  EXPECT_EQ(newest().seen_at, 77u) << "how old the answer is";
  EXPECT_EQ(judge(contacts(2)), IngressVerdict::kAccepted);
  EXPECT_EQ(newest().planes.compliance.size(), 0) << "planes carry no law";
  EXPECT_EQ(newest().planes.curvature.size(), 0);
  EXPECT_EQ(newest().planes.laws.cols(), 0);
}

TEST_F(IngressContactsTest, UncertaintyCountsIfAllTellIt) {
  ProxySample sample = contacts(2);
  sample.planes[0].tells_uncertainty = 1;
  EXPECT_EQ(judge(sample), IngressVerdict::kAccepted);
  EXPECT_EQ(newest().planes.uncertainty.size(), 0);
  sample = contacts(2);
  sample.planes[0].tells_uncertainty = sample.planes[1].tells_uncertainty = 1;
  sample.planes[1].uncertainty = 0.25;
  EXPECT_EQ(judge(sample), IngressVerdict::kAccepted);
  ASSERT_EQ(newest().planes.uncertainty.size(), 2);
  EXPECT_EQ(newest().planes.uncertainty[0], 0.0);
  EXPECT_EQ(newest().planes.uncertainty[1], 0.25);
}

TEST_F(IngressContactsTest, NamesAndIgnoresAWrongLaw) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](const char* word, auto spoil) {
    ProxySample sample = contacts(3);
    sample.planes[0].id = 4;
    spoil(sample.planes[2]);
    EXPECT_EQ(judge(sample), IngressVerdict::kBadPlane) << word;
    EXPECT_NE(why.find(word), std::string::npos) << why;
  };
  refused("planes[2].compliance = -1: must", [](auto& p) { p.compliance = -1.0; });
  refused("planes[2].compliance = nan: must", [&](auto& p) { p.compliance = nan; });
  refused("planes[2].compliance", [](auto& p) { p.compliance = 2e18; });
  refused("planes[2].uncertainty = -1: must lie within 0..1e6", [](auto& p) {
    p.tells_uncertainty = 1;
    p.uncertainty = -1.0;
  });
  refused("planes[2].uncertainty = nan", [&](auto& p) {
    p.tells_uncertainty = 1;
    p.uncertainty = nan;
  });
  refused("planes[2].velocity = nan: must", [&](auto& p) { p.velocity = nan; });
  refused("planes[2].velocity", [](auto& p) { p.velocity = -2e9; });
  refused("planes[2].curvature has 2 values: must", [](auto& p) { curve(p, {1.0, 2.0}); });
  refused("planes[2].curvature has 55 values", [](auto& p) { p.curvature_count = 55; });
  refused("planes[2].curvature has 4294967295 values", [](auto& p) { p.curvature_count = ~0u; });
  refused("planes[2].first_coordinate = 0: must leave room for 3 of 2", [](auto& p) {
    curve(p, {1, 2, 3, 4, 5, 6});
  });
  refused("planes[2].first_coordinate = 4294967295: must", [](auto& p) {
    curve(p, {1.0});
    p.first_coordinate = ~0u;
  });
  refused("planes[2].curvature[1] = nan: must", [&](auto& p) { curve(p, {1.0, nan, 1.0}); });
  refused("planes[2].curvature[0]", [](auto& p) { curve(p, {2e9}); });
  refused("planes[2].mass = -1: must be 0 or", [](auto& p) { p.mass = -1.0; });
  refused("planes[2].mass = 1e-19: must", [](auto& p) { p.mass = 1e-19; });
  refused("planes[2].mass = nan: must", [&](auto& p) { p.mass = nan; });
  refused("planes[2].damping = 2e+18: must", [](auto& p) { p.damping = 2e18; });
  refused("planes[2].ground_stiffness = -2: must", [](auto& p) { p.ground_stiffness = -2.0; });
  refused("planes[2].load = nan: must lie", [&](auto& p) { p.load = nan; });
  refused("planes[2].mass = 0: must be above 0", [](auto& p) { p.load = 1.0; });
  refused("planes[2].id = 0: must be given with a mass", [](auto& p) { p.mass = 1.0; });
  refused("planes[2].id = 4: must be unique, planes[0]", [](auto& p) { p.id = 4; });
  EXPECT_EQ(newest().seq, 0U);
}

TEST_F(IngressContactsTest, CurvatureOfASampleIsBounded) {
  Ingress eight(mailbox, 8);
  eight.begin_lease(1, 60.0, 100ms);
  ProxySample sample = contacts(8);
  sample.epoch = 1;
  sample.position.count = 8;
  for (PlaneSample& plane : sample.planes) {
    plane.normal.count = 8;
    plane.curvature_count = 36;
    plane.normal.value[43] = 2.0;
  }
  EXPECT_TRUE(eight.accept(sample).used());
  EXPECT_TRUE(newest().planes.fits(8));
  EXPECT_EQ(newest().planes.curvature[8 * 36 - 1], 2.0);
  sample.plane_count = 9;
  ++sample.seq;
  sample.planes[8].normal.value[0] = 1.0;
  EXPECT_NE(eight.accept(sample).why.str().find("324 values: at most 320 together"),
            std::string::npos);
}

/// A device with so many coordinates that a block of 8 has no room behind the normal.
TEST(IngressOfManyCoordinates, SaysWhatCurvatureFits) {
  core::Mailbox<core::ProxySnapshot> mailbox;
  Ingress ingress(mailbox, 72);
  ingress.begin_lease(1, 60.0, std::chrono::milliseconds(100));
  ProxySample sample{.epoch = 1, .seq = 1, .mode = core::ProxyMode::kPlanes, .plane_count = 1};
  sample.position.count = sample.planes[0].normal.count = 72;
  sample.planes[0].normal.value[70] = 1.0;
  sample.planes[0].curvature_count = 6;
  sample.planes[0].first_coordinate = 69;
  sample.planes[0].normal.value[77] = 5.0;
  EXPECT_TRUE(ingress.accept(sample).used());
  sample.seq = 2;
  sample.planes[0].curvature_count = 10;
  sample.planes[0].first_coordinate = 68;
  EXPECT_NE(ingress.accept(sample).why.str().find("curvature has 10 values: at most 8 with 72"),
            std::string::npos);
}

TEST_F(IngressPlanesTest, PlanesNeedAPosition) {
  EXPECT_EQ(send({}, t0, core::ProxyMode::kPlanes), IngressVerdict::kWrongSize);
}

}  // namespace
}  // namespace haptic::server
