/// Planes that are contacts, at the ingress.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <span>

#include "tests/server/owner/ingress/ingress_fixture.hpp"
#include "tests/support/identical.hpp"

namespace haptic::server {
namespace {

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
  EXPECT_EQ(planes.ids, Eigen::Vector2d(0.0, 9.0));
  EXPECT_EQ(planes.curved[0], 0);
  EXPECT_EQ(planes.curved[1], 2);
  EXPECT_EQ(planes.first[1], 0);
  EXPECT_EQ(planes.curvature[0], 1.0);
  EXPECT_EQ(planes.curvature[1], 0.0) << "subnormal numbers become 0";
  EXPECT_EQ(planes.curvature[2], 3.0);
  EXPECT_EQ(newest().anchored_at, 77u);
}

TEST_F(IngressContactsTest, NothingOfOlderSamplesRemains) {
  for (int i = 0; i < 3; ++i) {  // one in each place of the mailbox
    ProxySample sample = contacts(2);
    sample.arrival += std::chrono::milliseconds(100 * i);  // none is backlog
    for (PlaneSample& plane : std::span(sample.planes).first(2)) {
      plane.compliance = plane.velocity = plane.mass = 1.0;
      plane.id = static_cast<std::uint32_t>(&plane - sample.planes.data()) + 1;
      plane.tells_uncertainty = 1;
      plane.object = 4;
      plane.object_direction = {1.0};
      plane.first_coordinate = 1;
      curve(plane, {1.0});
    }
    ASSERT_EQ(judge(sample), IngressVerdict::kAccepted) << why;
    ASSERT_EQ(newest().planes.first[1], 1);
  }
  ProxySample last = contacts(1);
  last.arrival += std::chrono::seconds(1);
  EXPECT_EQ(judge(last), IngressVerdict::kAccepted);
  core::PlaneSet bare;
  bare.normals = Eigen::Vector2d(1.0, 0.0);
  bare.offsets = core::VecX::Constant(1, 1.0);
  EXPECT_TRUE(core::identical(newest().planes, bare));
  EXPECT_EQ(newest().anchored_at, 0u);
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
  EXPECT_EQ(newest().planes.ids.size(), 0);
}

TEST_F(IngressContactsTest, ContactsOfOneObject) {
  const auto pushed = [&](std::uint32_t count) {
    ProxySample sample = contacts(count);
    for (std::uint32_t i = 0; i < count; ++i) {
      sample.planes[i].id = i + 1;
      sample.planes[i].mass = 2e-4;
    }
    return sample;
  };
  EXPECT_EQ(judge(pushed(2)), IngressVerdict::kAccepted);
  EXPECT_EQ(newest().planes.objects.cols(), 0);
  ProxySample sample = pushed(2);
  sample.planes[1].object = 4'000'000'000u;
  sample.planes[1].object_direction = {0.6, -0.8};
  EXPECT_EQ(judge(sample), IngressVerdict::kAccepted);
  ASSERT_TRUE(newest().planes.fits(2));
  EXPECT_TRUE(newest().planes.objects.col(0).isZero(0.0));
  EXPECT_EQ(newest().planes.objects.col(1).head<3>(), Eigen::Vector3d(4e9, 0.6, -0.8));
  EXPECT_TRUE(newest().planes.objects.col(1).tail<4>().isZero(0.0));
  const auto refused = [&](const std::function<void(PlaneSample&)>& spoil, const char* field) {
    sample = pushed(2);
    sample.planes[1].object = 1;
    sample.planes[1].object_direction = {1.0};
    spoil(sample.planes[1]);
    EXPECT_EQ(judge(sample), IngressVerdict::kBadPlane);
    EXPECT_NE(why.find(field), std::string::npos) << why;
  };
  refused([](PlaneSample& p) { p.object = 0; }, "planes[1].object = 0");
  refused([](PlaneSample& p) { p.mass = 0.0; }, "planes[1].mass = 0");
  refused([](PlaneSample& p) { p.object_direction = {}; }, "object_direction has 0 values");
  refused([](PlaneSample& p) { p.object_direction.count = 7; }, "object_direction has 7 values");
  refused([](PlaneSample& p) { p.object_direction = {0.9}; }, "object_direction has length 0.9");
  refused([](PlaneSample& p) { p.object_direction = {std::nan("")}; }, "has length nan");
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

}  // namespace
}  // namespace haptic::server
