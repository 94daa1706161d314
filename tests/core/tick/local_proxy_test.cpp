#include "core/src/tick/local_proxy.hpp"

#include <gtest/gtest.h>

#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

ConfigurationSpace two_lines() {
  return ConfigurationSpace(
      {{"a", Unit::kMetre, CoordinateKind::kLinear}, {"b", Unit::kMetre, CoordinateKind::kLinear}});
}

ProxySnapshot sample_of(ProxyMode mode, std::uint64_t seq) {
  ProxySnapshot sample;
  sample.mode = mode;
  sample.seq = seq;
  sample.x = two(1.0, 2.0);
  sample.planes.normals = MatXQ::Identity(2, 1);
  sample.planes.offsets = one(0.5);
  return sample;
}

TEST(LocalProxy, HeldProxyStays) {
  const ConfigurationSpace space = two_lines();
  LocalProxy local(space);
  const ProxySnapshot held = sample_of(ProxyMode::kHeld, 1);
  EXPECT_EQ(local.step(held, two(0.0, 0.0)), two(1.0, 2.0));
  EXPECT_TRUE(local.in_the_way() && local.changed() && local.new_sample());
  EXPECT_EQ(local.step(held, two(3.0, 0.0)), two(1.0, 2.0));
  EXPECT_FALSE(local.changed() || local.new_sample());
}

TEST(LocalProxy, FreeIsTheProbe) {
  const ConfigurationSpace space = two_lines();
  LocalProxy local(space);
  EXPECT_EQ(local.step(sample_of(ProxyMode::kFree, 1), two(3.0, 4.0)), two(3.0, 4.0));
  EXPECT_FALSE(local.in_the_way());
}

TEST(LocalProxy, NoneIsEmpty) {
  const ConfigurationSpace space = two_lines();
  LocalProxy local(space);
  EXPECT_EQ(local.step({}, two(3.0, 4.0)).size(), 0);
  EXPECT_FALSE(local.in_the_way() || local.changed());
}

TEST(LocalProxy, PlanesKeepTheProbeOut) {
  const ConfigurationSpace space = two_lines();
  LocalProxy local(space);
  const ProxySnapshot planes = sample_of(ProxyMode::kPlanes, 1);
  EXPECT_EQ(local.step(planes, two(0.2, 7.0)), two(0.2, 7.0));
  EXPECT_FALSE(local.in_the_way());
  EXPECT_NEAR((local.step(planes, two(0.8, 7.0)) - two(0.5, 7.0)).norm(), 0.0, 1e-9);
  EXPECT_TRUE(local.in_the_way() && local.changed());
  EXPECT_EQ(local.planes(), PlaneStatus::kActive);
  EXPECT_EQ(local.active_planes(), 1u);
}

TEST(LocalProxy, EachSampleBringsItsOwnPlanes) {
  const ConfigurationSpace space = two_lines();
  LocalProxy local(space);
  static_cast<void>(local.step(sample_of(ProxyMode::kPlanes, 1), two(0.8, 7.0)));
  ProxySnapshot next = sample_of(ProxyMode::kPlanes, 2);
  next.planes.offsets = one(0.6);
  EXPECT_NEAR(local.step(next, two(0.8, 7.0))[0], 0.6, 1e-9);
  EXPECT_TRUE(local.new_sample());
}

}  // namespace
}  // namespace haptic::core
