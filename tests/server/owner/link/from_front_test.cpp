#include "server/owner/link/from_front.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "haptic/wire/utf8.hpp"

namespace haptic::server {
namespace {

using namespace std::chrono_literals;
using core::TimePoint;

TEST(ArrivalOrder, StaysBetweenTheLastAndNow) {
  ArrivalOrder order;
  EXPECT_EQ(order.in_order(TimePoint(5s), TimePoint(9s)), TimePoint(5s));
  EXPECT_EQ(order.in_order(TimePoint(3s), TimePoint(9s)), TimePoint(5s)) << "never back";
  EXPECT_EQ(order.in_order(TimePoint(20s), TimePoint(9s)), TimePoint(9s)) << "no future";
  EXPECT_EQ(order.in_order(TimePoint::min(), TimePoint(10s)), TimePoint(9s));
  EXPECT_EQ(order.in_order(TimePoint::max(), TimePoint(10s)), TimePoint(10s));
}

/// A value whose every byte is `byte`.
template <typename T>
T filled(int byte) {
  T value;
  std::memset(static_cast<void*>(&value), byte, sizeof value);
  return value;
}

TEST(FromFront, SamplesOfJunkHaveKnownNames) {
  for (int byte = 0; byte < 256; ++byte) {
    auto sample = filled<ProxySample>(byte);
    make_harmless(sample, TimePoint(7s));
    EXPECT_LE(sample.mode, core::ProxyMode::kPlanes);
    EXPECT_TRUE(sample.carrier == Carrier::kGrpc || sample.carrier == Carrier::kUdp ||
                sample.carrier == Carrier::kWebSocket);
    EXPECT_EQ(sample.arrival, TimePoint(7s));
    EXPECT_GE(sample.valid_for, 0s);
    EXPECT_LE(sample.valid_for, std::chrono::hours(2));
    const server::Departure left = sample.left.value_or(server::Departure{});
    EXPECT_GE(left.likely, TimePoint{});
    EXPECT_GE(left.latest, TimePoint{});
  }
}

TEST(FromFront, RequestsOfJunkAreNobodys) {
  for (int byte = 0; byte < 256; ++byte) {
    auto request = filled<Request>(byte);
    if (!make_harmless(request, TimePoint(7s))) continue;
    EXPECT_LE(request.kind, Request::Kind::kCancel);
    EXPECT_FALSE(request.local) << "that is the control socket's";
    EXPECT_EQ(request.time, TimePoint(7s));
    EXPECT_LE(request.lease.priority, Priority::kOperator);
    EXPECT_LE(request.text.view().size(), 200U);
    EXPECT_LE(request.lease.client_name.view().size(), 64U);
    EXPECT_TRUE(wire::is_utf8(request.text.view()) &&
                wire::is_utf8(request.lease.client_name.view()))
        << "clients could not read what is told of it";
    EXPECT_LE(request.lease.fade_end.value_or(0s), std::chrono::hours(24));
  }
}

TEST(FromFront, ReasonsCanBeRead) {
  StopAhead stop{0, "\xff\x1b[31m\nhot"};
  make_harmless(stop);
  EXPECT_EQ(stop.why.view(), R"(\xff\x1b[31m\x0ahot)");
}

TEST(FromFront, HonestRequestsStayAsTheyAre) {
  Request request{.id = 5, .kind = Request::Kind::kSettings, .device = 2};
  request.settings.renderer = core::RendererKind::kSubspaceExact;
  request.lease.fresh_end = 20ms;
  ASSERT_TRUE(make_harmless(request, TimePoint(7s)));
  EXPECT_EQ(request.id, 5U);
  EXPECT_EQ(*request.settings.renderer, core::RendererKind::kSubspaceExact);
  EXPECT_EQ(*request.lease.fresh_end, core::Duration(20ms));
}

}  // namespace
}  // namespace haptic::server
