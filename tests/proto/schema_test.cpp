/// The reading of messages by descriptor, and the options of DeviceState's fields.

#include "haptic/schema/fields.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "haptic/core/fault.hpp"
#include "haptic/v1/session.pb.h"

namespace haptic::schema {
namespace {

namespace pb = google::protobuf;

const pb::FieldDescriptor& field(const char* name) {
  return *v1::DeviceState::descriptor()->FindFieldByName(name);
}

std::string text(const v1::DeviceState& state, const char* name, int index = 0) {
  std::string text;
  append_value(state, field(name), index, text);
  return text;
}

TEST(Schema, UnitFollowsTheLabel) {
  EXPECT_EQ(unit_of(field("tau_a"), {"slide", "m"}), "N");
  EXPECT_EQ(unit_of(field("tau_a"), {"swing", "rad"}), "N m");
  EXPECT_EQ(unit_of(field("q_dot"), {"swing", "rad"}), "rad/s");
  EXPECT_EQ(unit_of(field("stiffness_in_effect"), {"swing", "rad"}), "N m/rad");
  EXPECT_EQ(unit_of(field("proxy_age_us")), "us");
  EXPECT_EQ(unit_of(field("gain")), "");
}

TEST(Schema, NumbersReadBackToTheirBits) {
  v1::DeviceState state;
  state.add_q(0.1 + 0.2);
  state.add_q(std::numeric_limits<double>::quiet_NaN());
  state.set_server_time_ns(std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(text(state, "q"), "0.30000000000000004");
  EXPECT_EQ(text(state, "q", 1), "nan");
  EXPECT_EQ(text(state, "server_time_ns"), "9223372036854775807");
}

TEST(Schema, EnumValuesLoseTheirPrefix) {
  v1::DeviceState state;
  EXPECT_EQ(text(state, "mode"), "NONE");
  state.set_mode(v1::PROXY_MODE_PLANES);
  EXPECT_EQ(text(state, "mode"), "PLANES");
  state.set_mode(static_cast<v1::ProxyMode>(77));  // of a newer server
  EXPECT_EQ(text(state, "mode"), "77");
}

TEST(Schema, BitsAreNamed) {
  v1::DeviceState state;
  EXPECT_EQ(text(state, "faults"), "");
  state.set_faults(1U << 5 | 1U << 7 | 1U << 31);
  EXPECT_EQ(text(state, "faults"), "LOOP_LATE|EMERGENCY_STOP|31");
}

TEST(Schema, BitNamesMatchTheCode) {
  for (unsigned n = 0; n < 32; ++n) {
    const auto expected = [n](std::string_view reason, std::string_view unknown) {
      return reason == unknown ? std::to_string(n) : std::string(reason);
    };
    const auto name = [n](const char* of) { return bit_names(field(of), 1U << n).at(0); };
    EXPECT_EQ(name("faults"), expected(core::reason(static_cast<core::Fault>(n)), "UNKNOWN"));
    const std::string limiter = expected(core::reason(static_cast<core::Limiter>(n)), "UNKNOWN");
    EXPECT_EQ(name("limiters"), limiter);
    EXPECT_EQ(name("actuator_limiters"), limiter);
  }
}

TEST(Schema, LeavesOfMessagesHaveTheirName) {
  v1::DeviceState state;
  for (const Leaf& leaf : leaves(*v1::DeviceState::descriptor())) {
    if (leaf.name != "passivity_tank") continue;
    EXPECT_EQ(count(state, leaf), 0);
    state.mutable_passivity()->set_tank(0.5);
    EXPECT_EQ(count(state, leaf), 1);
    return;
  }
  FAIL() << "no passivity_tank";
}

/// Repeated numbers without an axis could be labelled by nothing.
TEST(Schema, RepeatedFieldsHaveAnAxis) {
  for (const Leaf& leaf : leaves(*v1::DeviceState::descriptor())) {
    if (leaf.field->message_type() != nullptr) continue;
    EXPECT_EQ(leaf.field->is_repeated(), leaf.axis != v1::AXIS_UNSPECIFIED) << leaf.name;
    EXPECT_NE(leaf.field->cpp_type(), pb::FieldDescriptor::CPPTYPE_STRING) << leaf.name;
  }
}

}  // namespace
}  // namespace haptic::schema
