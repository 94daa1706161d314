#include "core/src/tick/local_proxy.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/vectors.hpp"

namespace haptic::core {
namespace {

ProxySnapshot sample_of(ProxyMode mode, std::uint64_t seq) {
  ProxySnapshot sample;
  sample.mode = mode;
  sample.seq = seq;
  sample.x = two(1.0, 2.0);
  sample.planes.normals = MatXQ::Identity(2, 1);
  sample.planes.offsets = one(0.5);
  return sample;
}

class LocalProxyTest : public ::testing::Test {
 protected:
  Anchor step(const ProxySnapshot& sample, double a, double b) {
    Anchor now;
    ++tick_;
    const TimePoint time{std::chrono::milliseconds(tick_)};
    local_.step(sample, {tick_, 0.0, time}, two(a, b), now);
    return now;
  }

  const ConfigurationSpace space_{
      {{"a", Unit::kMetre, CoordinateKind::kLinear}, {"b", Unit::kMetre, CoordinateKind::kLinear}}};
  LocalProxy local_{space_};
  std::uint64_t tick_{0};
};

/// A wall that moves at 0.1 m/s, told from the probe of tick 1, whose clock is late in tick 2.
TEST_F(LocalProxyTest, AgeErrorIsByTheClock) {
  ProxySnapshot sample = sample_of(ProxyMode::kPlanes, 1);
  sample.planes.compliance = sample.planes.uncertainty = VecX::Zero(1);
  sample.planes.velocity = VecX::Constant(1, 0.1);
  sample.anchored_at = 1;
  sample.x = two(0.5, 0.0);
  step({}, 0.6, 0.0);
  sample.born = TimePoint{std::chrono::milliseconds(6)};
  Anchor now;
  local_.step(sample, {2, 0.002, TimePoint{std::chrono::milliseconds(7)}}, two(0.6, 0.0), now);
  ASSERT_TRUE(local_.error().known);
  EXPECT_NEAR(local_.error().of.sum(), 0.1 * 0.004, 1e-12) << "6 ms since the probe, less 2";
}

TEST_F(LocalProxyTest, HeldProxyStays) {
  const ProxySnapshot held = sample_of(ProxyMode::kHeld, 1);
  const Anchor now = step(held, 0.0, 0.0);
  EXPECT_EQ(now.x, two(1.0, 2.0));
  EXPECT_TRUE(now.in_the_way && local_.changed() && local_.new_sample());
  EXPECT_EQ(step(held, 3.0, 0.0).x, two(1.0, 2.0));
  EXPECT_FALSE(local_.changed() || local_.new_sample());
}

TEST_F(LocalProxyTest, HeldGoesToTheNextSample) {
  ProxySnapshot held = sample_of(ProxyMode::kHeld, 1);
  for (int k = 0; k < 4; ++k) step(held, 0.0, 0.0);
  held.seq = 2;  // 4 ms after the first one
  held.x[1] = 6.0;
  for (const double b : {3.0, 4.0, 5.0, 6.0}) {
    EXPECT_EQ(step(held, 0.0, 0.0).x, two(1.0, b));
    EXPECT_TRUE(local_.changed());
  }
  EXPECT_EQ(step(held, 0.0, 0.0).x, two(1.0, 6.0)) << "never beyond the newest one";
  EXPECT_FALSE(local_.changed());
  held.seq = 3;  // 5 ms; the next one comes early, after 2 ms
  held.x[1] = 1.0;
  EXPECT_EQ(step(held, 0.0, 0.0).x[1], 5.0);
  EXPECT_EQ(step(held, 0.0, 0.0).x[1], 4.0);
  held.seq = 4;
  held.x[1] = 0.0;
  EXPECT_EQ(step(held, 0.0, 0.0).x[1], 2.0) << "from where it is";
  EXPECT_EQ(step(held, 0.0, 0.0).x[1], 0.0);
  held.seq = 5;  // 2 ms
  held.x[1] = 2.0;
  step(held, 0.0, 0.0);
  EXPECT_EQ(step(held, 0.0, 0.0).x[1], 2.0);
  for (const double b : {7.0, 8.0, 9.0}) {
    ++held.seq;
    held.x[1] = b;
    step(held, 0.0, 0.0);
  }
  EXPECT_EQ(step(held, 0.0, 0.0).x[1], 9.0) << "a sample in every tick is never late";
}

TEST_F(LocalProxyTest, HeldBeginsWhereItIsTold) {
  ProxySnapshot held = sample_of(ProxyMode::kHeld, 1);
  for (int k = 0; k < 200; ++k) step(held, 0.0, 0.0);
  held.seq = 2;
  held.x[1] = 4.0;
  for (int k = 0; k < 25; ++k) step(held, 0.0, 0.0);
  EXPECT_NEAR(step(held, 0.0, 0.0).x[1], 3.04, 1e-12) << "50 ms at most";
  held.seq = 3;
  held.tenure = 2;
  EXPECT_EQ(step(held, 0.0, 0.0).x[1], 4.0) << "another lease";
  step(held, 0.0, 0.0);
  step(sample_of(ProxyMode::kFree, 4), 0.0, 0.0);
  step(held, 0.0, 0.0);
  EXPECT_EQ(step(held, 0.0, 0.0).x[1], 4.0) << "another mode";
  step(held, 0.0, 3.0);
  held.seen_at = tick_;
  ++held.seq;
  held.x[1] = 3.0;  // where the probe was
  EXPECT_EQ(step(held, 0.0, 3.5).x[1], 3.5);
  ++held.seq;
  held.x[1] = 2.0;
  EXPECT_EQ(step(held, 0.0, 3.5).x[1], 2.0) << "a contact that begins";
}

TEST(LocalProxy, HeldTurnsTheShortWay) {
  const auto part = [](const char* name) {
    return Coordinate{name, Unit::kRadian, CoordinateKind::kQuaternion};
  };
  const ConfigurationSpace space({{"a", Unit::kRadian, CoordinateKind::kAngle},
                                  part("qx"),
                                  part("qy"),
                                  part("qz"),
                                  part("qw")});
  LocalProxy local(space);
  ProxySnapshot held;
  held.mode = ProxyMode::kHeld;
  Anchor now;
  for (std::uint64_t tick = 1; tick <= 3; ++tick) {
    held.seq = tick < 3 ? 1 : 2;
    held.x = (VecX(5) << (tick < 3 ? 3.0 : -3.0), 0.0, 0.0, 0.0, tick < 3 ? 1.0 : -1.0).finished();
    if (tick == 3) held.x.tail<4>() << 0.0, 0.0, std::sin(-0.2), -std::cos(-0.2);
    const VecX probe = VecX::Unit(5, 4);
    local.step(held, {tick, 0.0, TimePoint{std::chrono::milliseconds(tick)}}, probe, now);
  }
  EXPECT_NEAR(now.x[0], 3.0 + (std::numbers::pi - 3.0), 1e-12) << "half of the way over pi";
  EXPECT_NEAR(now.x[3], std::sin(0.1), 1e-12);
  EXPECT_NEAR(now.x[4], std::cos(0.1), 1e-12);
}

TEST_F(LocalProxyTest, HeldFollowsWhereItWasFree) {
  step({}, 1.0 + 5e-7, 3.0);  // tick 1; held at (1, 2)
  ProxySnapshot held = sample_of(ProxyMode::kHeld, 1);
  held.seen_at = 1;
  Anchor now = step(held, 0.5, 1.0);
  EXPECT_EQ(now.x, two(0.5, 2.0));
  EXPECT_TRUE(now.in_the_way);
  EXPECT_EQ(step(held, 0.25, 5.0).x, two(0.25, 2.0));
  EXPECT_TRUE(local_.changed()) << "x moves between samples";
  step({}, 1.0, 2.0);  // tick 4
  held.seq = 2;
  held.seen_at = 4;
  now = step(held, 0.5, 1.0);
  EXPECT_EQ(now.x, two(0.5, 1.0));
  EXPECT_FALSE(now.in_the_way) << "as free";
  held.seq = 3;
  held.x = two(1.0, 2.0 + 2e-6);
  EXPECT_EQ(step(held, 0.5, 1.0).x[1], held.x[1]) << "further than rounding";
}

TEST_F(LocalProxyTest, HeldPointIsNoEcho) {
  step({}, 0.0, 3.0);  // tick 1
  ProxySnapshot held = sample_of(ProxyMode::kHeld, 1);
  held.seen_at = 1;
  held.x = two(0.0, 2.0);
  step(held, 1.0, 2.0);  // tick 2: the probe is at the point
  held.seq = held.seen_at = 2;
  held.x = two(1.0, 2.0);
  EXPECT_EQ(step(held, 0.5, 2.5).x, two(0.5, 2.0));
  held.seq = held.seen_at = 3;
  held.x = two(0.5, 2.5);
  EXPECT_EQ(step(held, 0.5, 1.0).x, two(0.5, 1.0)) << "another point, hence free";
  held.seq = 4;
  EXPECT_EQ(step(held, 0.5, 4.0).x, two(0.5, 4.0)) << "it rested, free";
}

TEST_F(LocalProxyTest, HeldOfAnUnknownTickStays) {
  step({}, 1.0, 2.0);
  ProxySnapshot held = sample_of(ProxyMode::kHeld, 1);
  for (const std::uint64_t tick : {std::uint64_t{0}, std::uint64_t{9}, std::uint64_t{1}}) {
    ++held.seq;
    held.seen_at = tick;  // not told, of the future, too long ago
    for (int n = 0; tick == 1 && n < 1100; ++n) step({}, 1.0, 2.0);
    const Anchor now = step(held, 0.5, 1.0);
    EXPECT_EQ(now.x, two(1.0, 2.0)) << tick;
    EXPECT_TRUE(now.in_the_way);
  }
}

TEST(HeldRotation, IsFreeAsAWhole) {
  std::vector<Coordinate> parts(4, {"part", Unit::kRadian, CoordinateKind::kQuaternion});
  parts.push_back({"length", Unit::kMetre, CoordinateKind::kLinear});
  const ConfigurationSpace space(parts);
  LocalProxy local(space);
  const auto pose = [](double half) {  // a turn about x
    VecX x(5);
    x << std::sin(half), 0.0, 0.0, std::cos(half), 7.0;
    return x;
  };
  Anchor now;
  local.step({}, {1, 0.0, TimePoint{}}, pose(0.0), now);
  ProxySnapshot held;
  held.mode = ProxyMode::kHeld;
  held.seen_at = 1;
  held.x = pose(1e-4);  // three parts of it are the probe's, to rounding
  VecX probe = pose(0.3);
  probe[4] = 8.0;
  local.step(held, {2, 0.0, TimePoint{}}, probe, now);
  EXPECT_EQ(now.x.head<4>(), held.x.head<4>());
  EXPECT_EQ(now.x[4], 8.0);
  held.seq = 1;
  held.x = -pose(0.0);  // the same rotation
  local.step(held, {3, 0.0, TimePoint{}}, probe, now);
  EXPECT_EQ(now.x.head<4>(), probe.head<4>());
  held.seq = 2;
  held.x = pose(0.1);
  local.step(held, {4, 0.0, TimePoint{}}, held.x, now);
  held.seq = 3;
  held.seen_at = 4;  // the probe was at the pose that is held
  local.step(held, {5, 0.0, TimePoint{}}, probe, now);
  EXPECT_EQ(now.x.head<4>(), held.x.head<4>());
}

TEST_F(LocalProxyTest, FreeIsTheProbe) {
  const Anchor now = step(sample_of(ProxyMode::kFree, 1), 3.0, 4.0);
  EXPECT_EQ(now.x, two(3.0, 4.0));
  EXPECT_FALSE(now.in_the_way);
}

TEST_F(LocalProxyTest, NoneIsEmpty) {
  const Anchor now = step({}, 3.0, 4.0);
  EXPECT_EQ(now.x.size(), 0);
  EXPECT_FALSE(now.in_the_way || local_.changed());
}

TEST_F(LocalProxyTest, PlanesKeepTheProbeOut) {
  const ProxySnapshot planes = sample_of(ProxyMode::kPlanes, 1);
  Anchor now = step(planes, 0.2, 7.0);
  EXPECT_EQ(now.x, two(0.2, 7.0));
  EXPECT_FALSE(now.in_the_way);
  now = step(planes, 0.8, 7.0);
  EXPECT_NEAR((now.x - two(0.5, 7.0)).norm(), 0.0, 1e-9);
  EXPECT_TRUE(now.in_the_way && local_.changed());
  EXPECT_EQ(now.planes, PlaneStatus::kActive);
  EXPECT_EQ(now.active_planes, 1u);
}

TEST_F(LocalProxyTest, LateObjectsCatchUp) {
  ProxySnapshot pushed = sample_of(ProxyMode::kPlanes, 2);
  pushed.planes.compliance = one(1.0);
  pushed.planes.velocity = one(0.2);
  pushed.planes.laws = VecX::LinSpaced(4, 1e-3, 4e-3);
  pushed.anchored_at = 5;
  pushed.x = two(0.55, 7.0);
  for (const int late : {1, 40, 900}) {
    LocalProxy early(space_), other(space_);
    for (std::uint64_t tick = 1; tick <= 1000; ++tick) {
      const TimePoint time{std::chrono::milliseconds(tick)};
      const VecX probe = two(0.6 + 0.2 * std::sin(0.02 * static_cast<double>(tick - 5)), 7.0);
      Anchor soon, now;
      early.step(tick > 5 ? pushed : ProxySnapshot{}, {tick, 0.0, time}, probe, soon);
      other.step(tick >= 5u + late ? pushed : ProxySnapshot{}, {tick, 0.0, time}, probe, now);
      // 900 ticks are replayed in steps of two.
      if (tick < 5u + late) continue;
      ASSERT_NEAR(soon.x[0], now.x[0], late > 512 ? 1e-6 : 0.0) << tick;
    }
  }
}

TEST_F(LocalProxyTest, ContactsAnchorAtTheTickUsed) {
  step({}, 0.7, 7.0);  // tick 1
  step({}, 0.9, 7.0);
  ProxySnapshot contacts = sample_of(ProxyMode::kPlanes, 1);
  contacts.planes.compliance = one(1.0);
  contacts.x = two(0.55, 7.0);  // of the probe 0.7 the told law would make 0.6
  contacts.anchored_at = 1;
  Anchor now = step(contacts, 0.7, 7.0);
  EXPECT_NEAR(now.x[0], 0.55, 1e-8);
  EXPECT_NEAR(now.stored, now.coupling, 1e-6 * now.stored)
      << "as much as the coupling, with a compliance of 1";
  EXPECT_NEAR(now.unexplained, 0.0, 1e-8);
  contacts.seq = 2;
  contacts.x = two(0.55, 7.2);
  EXPECT_NEAR(step(contacts, 0.7, 7.0).unexplained, 0.2, 1e-8);
  contacts.seq = 3;
  contacts.anchored_at = tick_ + 2;  // of the future: as told
  now = step(contacts, 0.7, 7.0);
  EXPECT_NEAR(now.x[0], 0.6, 1e-9);
  EXPECT_EQ(now.unexplained, 0.0);
  contacts.seq = 4;
  contacts.anchored_at = 1;  // long ago: as told
  for (int n = 0; n < 1100; ++n) step({}, 0.7, 7.0);
  EXPECT_NEAR(step(contacts, 0.7, 7.0).x[0], 0.6, 1e-9);
}

TEST_F(LocalProxyTest, EachSampleBringsItsOwnPlanes) {
  step(sample_of(ProxyMode::kPlanes, 1), 0.8, 7.0);
  ProxySnapshot next = sample_of(ProxyMode::kPlanes, 2);
  next.planes.offsets = one(0.6);
  EXPECT_NEAR(step(next, 0.8, 7.0).x[0], 0.6, 1e-9);
  EXPECT_TRUE(local_.new_sample());
}

}  // namespace
}  // namespace haptic::core
