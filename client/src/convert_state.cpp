// DeviceState <-> v1::DeviceState, by the lists of fields in state.hpp: each member is read or
// written through the message's reflection, by its type. The descriptors are looked up by name
// once.
#include <type_traits>

#include "convert.hpp"
#include "google/protobuf/reflection.h"

namespace haptic::client {
namespace {

namespace pb = google::protobuf;
using pb::FieldDescriptor;

/// Descriptors of the fields that State lists, in that order. An unknown name is null, which the
/// tests find.
template <typename State>
const std::vector<const FieldDescriptor*>& fields_of(const pb::Descriptor& type) {
  static const auto fields = [&type] {
    std::vector<const FieldDescriptor*> found;
    State state;
    State::for_each(state,
                    [&](const char* name, auto&) { found.push_back(type.FindFieldByName(name)); });
    return found;
  }();
  return fields;
}

/// Calls f(descriptor, member) for every field that the structure lists.
template <typename State, typename F>
void for_each_field(State& state, const pb::Message& message, F f) {
  using Plain = std::remove_const_t<State>;
  const FieldDescriptor* const* next = fields_of<Plain>(*message.GetDescriptor()).data();
  Plain::for_each(state, [&](const char*, auto& member) { f(*next++, member); });
}

struct Reader {
  const pb::Message& message;
  const pb::Reflection& from = *message.GetReflection();

  template <typename State>
  void read(State& state) const {
    for_each_field(state, message, *this);
  }
  void operator()(const FieldDescriptor* field, double& to) const {
    to = from.GetDouble(message, field);
  }
  void operator()(const FieldDescriptor* field, std::uint64_t& to) const {
    to = from.GetUInt64(message, field);
  }
  void operator()(const FieldDescriptor* field, std::int64_t& to) const {
    to = from.GetInt64(message, field);
  }
  void operator()(const FieldDescriptor* field, std::uint32_t& to) const {
    to = field->enum_type() == nullptr
             ? from.GetUInt32(message, field)
             : static_cast<std::uint32_t>(from.GetEnumValue(message, field));
  }
  void operator()(const FieldDescriptor* field, std::chrono::microseconds& to) const {
    to = std::chrono::microseconds(from.GetUInt64(message, field));
  }
  template <typename Number>
  requires std::is_arithmetic_v<Number>
  void operator()(const FieldDescriptor* field, std::vector<Number>& to) const {
    const auto values = from.GetRepeatedFieldRef<Number>(message, field);
    to.assign(values.begin(), values.end());
  }
  template <typename State>
  void operator()(const FieldDescriptor* field, std::optional<State>& to) const {
    if (!from.HasField(message, field)) return;
    Reader{from.GetMessage(message, field)}.read(to.emplace());
  }
  template <typename State>
  void operator()(const FieldDescriptor* field, std::vector<State>& to) const {
    to.resize(static_cast<std::size_t>(from.FieldSize(message, field)));
    int next = 0;
    for (State& state : to) Reader{from.GetRepeatedMessage(message, field, next++)}.read(state);
  }
  template <typename Enum>
  requires std::is_enum_v<Enum>
  void operator()(const FieldDescriptor* field, Enum& to) const {
    to = static_cast<Enum>(from.GetEnumValue(message, field));
  }
};

struct Writer {
  pb::Message& message;
  const pb::Reflection& to = *message.GetReflection();

  template <typename State>
  void write(const State& state) const {
    for_each_field(state, message, *this);
  }
  void operator()(const FieldDescriptor* field, double from) const {
    to.SetDouble(&message, field, from);
  }
  void operator()(const FieldDescriptor* field, std::uint64_t from) const {
    to.SetUInt64(&message, field, from);
  }
  void operator()(const FieldDescriptor* field, std::int64_t from) const {
    to.SetInt64(&message, field, from);
  }
  void operator()(const FieldDescriptor* field, std::uint32_t from) const {
    if (field->enum_type() != nullptr) {
      to.SetEnumValue(&message, field, static_cast<int>(from));
    } else {
      to.SetUInt32(&message, field, from);
    }
  }
  void operator()(const FieldDescriptor* field, std::chrono::microseconds from) const {
    to.SetUInt64(&message, field, static_cast<std::uint64_t>(from.count()));
  }
  template <typename Number>
  requires std::is_arithmetic_v<Number>
  void operator()(const FieldDescriptor* field, const std::vector<Number>& from) const {
    const auto values = to.GetMutableRepeatedFieldRef<Number>(&message, field);
    for (const Number value : from) values.Add(value);
  }
  template <typename State>
  void operator()(const FieldDescriptor* field, const std::optional<State>& from) const {
    if (from) Writer{*to.MutableMessage(&message, field)}.write(*from);
  }
  template <typename State>
  void operator()(const FieldDescriptor* field, const std::vector<State>& from) const {
    for (const State& state : from) Writer{*to.AddMessage(&message, field)}.write(state);
  }
  template <typename Enum>
  requires std::is_enum_v<Enum>
  void operator()(const FieldDescriptor* field, Enum from) const {
    to.SetEnumValue(&message, field, static_cast<int>(from));
  }
};

}  // namespace

DeviceState to_state(const v1::DeviceState& message) {
  DeviceState state;
  Reader{message}.read(state);
  state.received = std::chrono::steady_clock::now();
  return state;
}

v1::DeviceState to_message(const DeviceState& state) {
  v1::DeviceState message;
  Writer{message}.write(state);
  return message;
}

}  // namespace haptic::client
