// v1::DeviceState -> DeviceState, by the lists of fields in state.hpp: each member is read through
// the message's reflection, by its type. The descriptors are looked up by name once.
#include <type_traits>

#include "convert.hpp"
#include "google/protobuf/reflection.h"

namespace haptic::client {
namespace {

namespace pb = google::protobuf;
using pb::FieldDescriptor;

using Fields = std::vector<const FieldDescriptor*>;

/// Descriptors of the fields that State lists, in that order. An unknown name is null, which the
/// tests find. Never destroyed: a session that is open at exit() has states to read until it ends.
template <typename State>
const Fields& fields_of(const pb::Descriptor& type) {
  static const Fields& fields = *new const Fields([&type] {
    Fields found;
    State state;
    State::for_each(state,
                    [&](const char* name, auto&) { found.push_back(type.FindFieldByName(name)); });
    return found;
  }());
  return fields;
}

/// Calls f(descriptor, member) for every field that the structure lists.
template <typename State, typename F>
void for_each_field(State& state, const pb::Message& message, F f) {
  const FieldDescriptor* const* next = fields_of<State>(*message.GetDescriptor()).data();
  State::for_each(state, [&](const char*, auto& member) { f(*next++, member); });
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

}  // namespace

DeviceState to_state(const v1::DeviceState& message) {
  DeviceState state;
  Reader{message}.read(state);
  state.received = std::chrono::steady_clock::now();
  state.message = message.SerializeAsString();
  return state;
}

}  // namespace haptic::client
