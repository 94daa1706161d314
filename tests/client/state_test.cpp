/// DeviceState against the protocol's descriptor: what the server says and the library does not
/// carry shows here.

#include <gtest/gtest.h>

#include <memory>

#include "client/src/convert.hpp"
#include "haptic/client/state_fields.hpp"

namespace haptic::client {
namespace {

namespace pb = google::protobuf;

/// A value of its own for every field: numbers rise, a list gets two entries.
void fill(pb::Message& message, int& next) {
  const pb::Reflection& r = *message.GetReflection();
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const pb::FieldDescriptor* const f = message.GetDescriptor()->field(i);
    const auto number = static_cast<std::uint32_t>(++next);
    for (int k = 0; k < (f->is_repeated() ? 2 : 1); ++k) {
      switch (f->cpp_type()) {
        case pb::FieldDescriptor::CPPTYPE_DOUBLE:
          f->is_repeated() ? r.AddDouble(&message, f, number + 0.25 * k)
                           : r.SetDouble(&message, f, number + 0.5);
          break;
        case pb::FieldDescriptor::CPPTYPE_UINT32:
          f->is_repeated() ? r.AddUInt32(&message, f, number + 1)
                           : r.SetUInt32(&message, f, number);
          break;
        case pb::FieldDescriptor::CPPTYPE_UINT64:
          r.SetUInt64(&message, f, number);
          break;
        case pb::FieldDescriptor::CPPTYPE_INT64:
          r.SetInt64(&message, f, number);
          break;
        case pb::FieldDescriptor::CPPTYPE_ENUM:
          r.SetEnumValue(&message, f, f->enum_type()->value(1 + next % 2)->number());
          break;
        case pb::FieldDescriptor::CPPTYPE_MESSAGE:
          fill(f->is_repeated() ? *r.AddMessage(&message, f) : *r.MutableMessage(&message, f),
               next);
          break;
        default:
          FAIL() << f->full_name() << ": fill() knows no " << f->cpp_type_name();
      }
    }
  }
}

v1::DeviceState full_message() {
  v1::DeviceState message;
  int next = 0;
  fill(message, next);
  return message;
}

DeviceInfo slider() {
  DeviceInfo device;
  device.dofs = {{"slide", "m", true, 0.0, 0.1, 10.0}, {"swing", "rad", false, -1.0, 1.0, 0.0}};
  device.coordinates = {{"x", "m", "linear"}, {"phi", "rad", "angle"}};
  return device;
}

/// Without when it came.
DeviceState members(const v1::DeviceState& message) {
  DeviceState state = to_state(message);
  state.received = {};
  return state;
}

/// Removes each field of `part`, a message within `whole`, and wants to see that in the members.
void expect_all_carried(v1::DeviceState& whole, pb::Message& part) {
  const pb::Reflection& r = *part.GetReflection();
  const DeviceState full = members(whole);
  for (int i = 0; i < part.GetDescriptor()->field_count(); ++i) {
    const pb::FieldDescriptor* const field = part.GetDescriptor()->field(i);
    if (field->message_type() != nullptr) {
      expect_all_carried(whole, field->is_repeated() ? *r.MutableRepeatedMessage(&part, field, 0)
                                                     : *r.MutableMessage(&part, field));
    }
    const std::unique_ptr<pb::Message> before(part.New());
    before->CopyFrom(part);
    r.ClearField(&part, field);
    EXPECT_FALSE(members(whole) == full) << field->full_name();
    part.CopyFrom(*before);
  }
}

TEST(State, CarriesEveryFieldOfTheProtocol) {
  v1::DeviceState sent = full_message();
  expect_all_carried(sent, sent);
}

TEST(State, AbsentMessagesStayAbsent) {
  const DeviceState state = to_state({});
  EXPECT_FALSE(state.passivity || state.tracker);
}

TEST(StateFields, MatchTheProtocolInOrder) {
  const auto fields = state_fields(slider(), to_state(full_message()));
  const pb::Descriptor& type = *v1::DeviceState::descriptor();
  ASSERT_EQ(fields.size(), static_cast<std::size_t>(type.field_count()));
  for (int i = 0; i < type.field_count(); ++i) {
    const StateField& field = fields[static_cast<std::size_t>(i)];
    EXPECT_EQ(field.name, type.field(i)->name());
    EXPECT_NE(field.values.empty(), field.messages.empty()) << field.name;
    EXPECT_TRUE(!field.repeated || !field.messages.empty() || field.axis != "") << field.name;
  }
}

}  // namespace
}  // namespace haptic::client
