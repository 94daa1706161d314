/// The library's types against the protocol's descriptor: a field that the library does not carry
/// shows here.

#include <gtest/gtest.h>

#include <string>

#include "client/src/convert.hpp"
#include "client/src/convert_state.hpp"

namespace haptic::client {
namespace {

namespace pb = google::protobuf;

/// A value of its own for every field: numbers rise, a list gets two entries.
void fill(pb::Message& message, int& next) {
  const pb::Reflection& r = *message.GetReflection();
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const pb::FieldDescriptor* const f = message.GetDescriptor()->field(i);
    if (f->name() == "drawing") continue;  // only the page draws a device
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
        case pb::FieldDescriptor::CPPTYPE_STRING:
          f->is_repeated() ? r.AddString(&message, f, f->name())
                           : r.SetString(&message, f, f->name());
          break;
        case pb::FieldDescriptor::CPPTYPE_BOOL:
          r.SetBool(&message, f, true);
          break;
        case pb::FieldDescriptor::CPPTYPE_INT32:
          r.SetInt32(&message, f, static_cast<std::int32_t>(number));
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

/// The message, read and written again.
template <typename Type, typename Message>
std::string carried(const Message& message) {
  Type value;
  read(message, value);
  Message again;
  write(value, again);
  return again.DebugString();
}

template <typename Message>
Message full() {
  Message message;
  int next = 0;
  fill(message, next);
  return message;
}

TEST(State, CarriesEveryFieldOfTheProtocol) {
  const auto sent = full<v1::DeviceState>();
  EXPECT_EQ(carried<DeviceState>(sent), sent.DebugString());
}

TEST(Facts, CarryEveryFieldOfTheProtocol) {
  const auto device = full<v1::Device>();
  EXPECT_EQ(carried<DeviceInfo>(device), device.DebugString());
  const auto server = full<v1::GetServerInfoResponse>();
  EXPECT_EQ(carried<ServerInfo>(server), server.DebugString());
  const auto links = full<v1::GetLinkStatsResponse>();
  EXPECT_EQ(carried<LinkReport>(links), links.DebugString());
  const auto event = full<v1::Event>();
  EXPECT_EQ(carried<Event>(event), event.DebugString());
}

TEST(Facts, AbsentFiguresStayAbsent) {
  v1::GetLinkStatsResponse message;
  message.add_sessions()->add_transports();
  const auto session = read_as<LinkReport>(message).sessions.front();
  EXPECT_FALSE(session.clock || session.age_p50 || session.carriers.front().round_trip);
}

TEST(State, AbsentMessagesStayAbsent) {
  const DeviceState state = to_state({});
  EXPECT_FALSE(state.passivity || state.tracker);
}

}  // namespace
}  // namespace haptic::client
