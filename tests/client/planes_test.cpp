#include "haptic/client/planes.hpp"

#include <cmath>

#include "tests/client/support/fake_server.hpp"

namespace haptic::test {
namespace {

using Publish = WithServer;
using client::Block;
using client::derive_planes;
using client::keep_deepest;
using client::Plane;
using client::VirtualCoordinate;

std::vector<VirtualCoordinate> linear(std::size_t n) {
  return std::vector<VirtualCoordinate>(n, {"x", "m", "linear"});
}

double at(const Plane& plane, const std::vector<double>& x) {
  double sum = -plane.offset;
  for (std::size_t i = 0; i < x.size(); ++i) sum += plane.normal[i] * x[i];
  return sum;
}

TEST(DerivePlanes, HoldTheProxyAndFaceProbe) {
  const std::vector<double> x{1.0, 2.0}, x_probe{4.0, 6.0};
  const auto planes = derive_planes(linear(2), x, x_probe);
  ASSERT_EQ(planes.size(), 1u);
  EXPECT_NEAR(planes[0].normal[0], 0.6, 1e-15);
  EXPECT_NEAR(planes[0].normal[1], 0.8, 1e-15);
  EXPECT_NEAR(at(planes[0], x), 0.0, 1e-15);
  EXPECT_NEAR(at(planes[0], x_probe), 5.0, 1e-14) << "the probe is outside by its distance";
}

TEST(DerivePlanes, AFreeBlockHasNone) {
  EXPECT_TRUE(derive_planes(linear(2), {1, 2}, {1, 2}).empty());
  const auto planes =
      derive_planes(linear(4), {1, 2, 3, 4}, {1, 2, 3, 5}, {Block{0, 2}, Block{2, 2}});
  ASSERT_EQ(planes.size(), 1u);
  EXPECT_EQ(planes[0].normal, (std::vector<double>{0, 0, 0, 1}));
  EXPECT_EQ(planes[0].offset, 4.0);
}

TEST(DerivePlanes, AnglesGoTheShortWayRound) {
  const std::vector<VirtualCoordinate> circle{{"phi", "rad", "angle"}};
  const auto planes = derive_planes(circle, {3.1}, {-3.1});
  ASSERT_EQ(planes.size(), 1u);
  EXPECT_EQ(planes[0].normal[0], 1.0) << "-3.1 lies 0.08 rad beyond 3.1";
}

TEST(DerivePlanes, AQuaternionsSignDoesNotMatter) {
  std::vector<VirtualCoordinate> pose{{"z", "m", "linear"}};
  for (const char* part : {"x", "y", "z", "w"}) pose.push_back({part, "rad", "quaternion"});
  const std::vector<double> x{0, 0, 0, 0, 1}, turned{0, 0.6, 0, 0, 0.8},
      negative{0, -0.6, 0, 0, -0.8};
  const auto a = derive_planes(pose, x, turned), b = derive_planes(pose, x, negative);
  ASSERT_EQ(a.size(), 1u);
  ASSERT_EQ(b.size(), 1u);
  EXPECT_EQ(a[0].normal, b[0].normal);
  EXPECT_GT(a[0].normal[1], 0.9);
}

/// 40 planes of one coordinate with x_probe 1; every third is 0.5 deep, the others not reached.
std::vector<Plane> forty() {
  std::vector<Plane> planes;
  for (int i = 0; i < 40; ++i) planes.push_back({{2.0, 0.0}, i % 3 == 0 ? 1.0 : 3.0 + i});
  return planes;
}

TEST(KeepDeepest, LeavesThirtyTwoInTheirOrder) {
  std::vector<Plane> planes = forty();
  EXPECT_EQ(keep_deepest(linear(2), {0, 0}, {1, 0}, planes), 8u);
  ASSERT_EQ(planes.size(), client::kMaxPlanes);
  // The fourteen deep ones, and the eighteen of the others that are nearest.
  int deep = 0;
  double last = -1.0;
  for (const Plane& plane : planes) {
    deep += plane.offset == 1.0 ? 1 : 0;
    if (plane.offset == 1.0) continue;
    EXPECT_GT(plane.offset, last);
    EXPECT_LT(plane.offset, 3.0 + 30);
    last = plane.offset;
  }
  EXPECT_EQ(deep, 14);
  EXPECT_EQ(keep_deepest(linear(2), {0, 0}, {1, 0}, planes), 0u) << "as many as are allowed";
}

TEST(KeepDeepest, UnknownProbeCountsFromX) {
  std::vector<Plane> planes = forty(), from_x = forty();
  EXPECT_EQ(keep_deepest(linear(2), {1, 0}, {}, planes), 8u);
  keep_deepest(linear(2), {0, 0}, {1, 0}, from_x);
  ASSERT_EQ(planes.size(), client::kMaxPlanes);
  for (std::size_t i = 0; i < planes.size(); ++i) EXPECT_EQ(planes[i].offset, from_x[i].offset);
}

/// Contact i of `count` with this support, at the distance i.
std::vector<Plane> contacts(int count, const std::vector<double>& normal) {
  std::vector<Plane> planes;
  for (int i = 0; i < count; ++i) planes.push_back({.normal = normal, .offset = 1.0 * i, .id = 1});
  return planes;
}

TEST(KeepDeepest, LeavesEightContactsOfABlock) {
  std::vector<Plane> planes = contacts(12, {1, 0, 0, 0});
  for (const Plane& other : contacts(3, {0, 0, 0, 1})) planes.push_back(other);
  EXPECT_EQ(keep_deepest(linear(4), {0, 0, 0, 0}, {0, 0, 0, 0}, planes), 4u);
  ASSERT_EQ(planes.size(), 11u);
  EXPECT_EQ(planes[7].offset, 7.0) << "the eight nearest";
  EXPECT_EQ(planes[10].normal[3], 1.0) << "another block";
}

TEST(KeepDeepest, FlattensWhatCurvatureHasNoRoom) {
  // 28 numbers each, as of a pose: eleven fit into a sample.
  std::vector<Plane> planes;
  for (std::size_t i = 0; i < 28; ++i) {
    planes.push_back(
        {.normal = std::vector<double>(28, 0.0), .offset = 27.0 - static_cast<double>(i)});
    planes.back().normal[i] = 1.0;
    planes.back().curvature.assign(28, 1.0);
  }
  EXPECT_EQ(keep_deepest(linear(28), std::vector<double>(28), {}, planes), 0u);
  for (std::size_t i = 0; i < 28; ++i) EXPECT_EQ(planes[i].curvature.empty(), i < 28 - 11) << i;
}

TEST(KeepDeepest, WhatIsNoNumberIsFarthest) {
  // Sorted by NaN these would be in no order at all.
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    std::vector<Plane> planes;
    for (int i = 0; i < 64; ++i) planes.push_back({{1.0}, i % 2 == 0 ? bad : 1.0 * (64 - i)});
    EXPECT_EQ(keep_deepest(linear(1), {0.0}, {}, planes), 32u);
    ASSERT_EQ(planes.size(), 32u);
    for (const Plane& plane : planes) EXPECT_TRUE(std::isfinite(plane.offset)) << bad;
  }
}

TEST(KeepDeepest, AnglesGoTheShortWayRound) {
  // The probe is 0.08 rad beyond the proxy, not a turn less that before it.
  std::vector<Plane> planes;
  for (int i = 0; i < 33; ++i) planes.push_back({{1.0}, 3.2 + 0.01 * i});
  planes[0] = {{-1.0}, 3.0};
  EXPECT_EQ(keep_deepest({{"phi", "rad", "angle"}}, {3.1}, {-3.1}, planes), 1u);
  EXPECT_EQ(planes[0].normal[0], 1.0) << "the one that faces away is the farthest";
}

TEST(DerivePlanes, WrongSizesGiveNone) {
  EXPECT_TRUE(derive_planes(linear(2), {1}, {1, 2}).empty());
  EXPECT_TRUE(derive_planes(linear(2), {1, 2}, {3, 4}, {Block{1, 2}}).empty());
  EXPECT_TRUE(derive_planes(linear(2), {1, 2}, {3, 4}, {Block{5, 1}}).empty());
}

TEST(Contact, IsItsGapAroundX) {
  // gap(x') = 0.25 + 3 (x' - 1) - 4 (y' - 2)
  const Plane plane = client::contact({1.0, 2.0}, 0.25, {3.0, -4.0});
  EXPECT_EQ(plane.normal, (std::vector<double>{-3.0, 4.0}));
  EXPECT_EQ(plane.offset - (-3.0 * 1.5 + 4.0 * 2.25), 0.25 + 3.0 * 0.5 - 4.0 * 0.25);
}

/// The test fails for a field of the protocol that it does not set.
TEST_F(Publish, CarriesContacts) {
  const auto session = open();
  Plane plane = client::contact({0.1, 0.2}, 0.01, {1.0, 0.0});
  plane.compliance = 3.0;
  plane.uncertainty = 0.0;
  plane.velocity = -0.5;
  plane.curvature = {2.0};
  plane.id = 7;
  plane.mass = 1e-4;
  plane.damping = 1e-3;
  plane.ground_stiffness = 0.2;
  plane.load = -0.5;
  plane.object = 3;
  plane.object_direction = {0.6, 0.8};
  plane.first_coordinate = 1;
  session->publish(client::Proxy::behind({{{1.0, 0.5}, 0.25}, plane}, {0.1, 0.2}));
  const v1::ProxySample sample = first_sample();
  EXPECT_EQ(sample.mode(), v1::PROXY_MODE_PLANES);
  EXPECT_EQ(sample.position(1), 0.2);
  ASSERT_EQ(sample.planes_size(), 2);
  EXPECT_EQ(sample.planes(0).normal(1), 0.5);
  const v1::Plane& sent = sample.planes(1);
  std::vector<const google::protobuf::FieldDescriptor*> set;
  sent.GetReflection()->ListFields(sent, &set);
  EXPECT_EQ(set.size(), static_cast<std::size_t>(v1::Plane::descriptor()->field_count()));
  EXPECT_EQ(sent.velocity(), -0.5);
  EXPECT_EQ(sent.curvature(0), 2.0);
  EXPECT_EQ(sent.id(), 7u);
  EXPECT_EQ(sent.load(), -0.5);
  EXPECT_EQ(sent.object_direction(1), 0.8);
}

TEST_F(Publish, LeavesOutAndCountsPlanes) {
  const auto session = open();
  session->publish(client::Proxy::behind(forty(), {0.0, 0.0}));
  EXPECT_EQ(first_sample().planes_size(), 32);
  EXPECT_EQ(session->statistics().planes_left_out, 8u);
}

TEST_F(Publish, DerivesContactsFromHeldProxies) {
  client::SessionOptions options{.derive_planes = true};
  const auto session = open(options);
  const std::size_t n_x = session->device().coordinates.size();
  session->publish(client::Proxy::held(std::vector<double>(n_x, 0.5)));
  ASSERT_TRUE(server.until([&] { return !server.heard().samples.empty(); }));
  EXPECT_EQ(server.heard().samples.back().mode(), v1::PROXY_MODE_HELD) << "no state, no probe";

  v1::SessionResponse message;
  message.mutable_state()->set_seq(5);
  for (std::size_t i = 0; i < n_x; ++i) message.mutable_state()->add_x_probe(1.5);
  server.send(message);
  ASSERT_EQ(session->wait_for_state().seq, 5u);
  session->publish(client::Proxy::held(std::vector<double>(n_x, 0.5)));
  ASSERT_TRUE(server.until([&] { return server.heard().samples.back().seq() == 2; }));
  EXPECT_EQ(server.heard().samples.back().mode(), v1::PROXY_MODE_HELD) << "never free";
  session->publish(client::Proxy::free());
  session->publish(client::Proxy::held(std::vector<double>(n_x, 0.5)));
  ASSERT_TRUE(
      server.until([&] { return server.heard().samples.back().mode() == v1::PROXY_MODE_PLANES; }));
  const v1::ProxySample sample = server.heard().samples.back();
  ASSERT_EQ(sample.planes_size(), 1);
  EXPECT_GT(sample.planes(0).normal(0), 0.0);
  EXPECT_EQ(sample.device_seq_used(), 5u);
  session->publish(client::Proxy::free());
  ASSERT_TRUE(
      server.until([&] { return server.heard().samples.back().mode() == v1::PROXY_MODE_FREE; }));
}

}  // namespace
}  // namespace haptic::test
