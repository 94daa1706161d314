#include "haptic/schema/fields.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <string_view>

namespace haptic::schema {
namespace {

namespace pb = google::protobuf;

void replace(std::string& text, std::string_view what, const std::string& with) {
  const std::size_t at = text.find(what);
  if (at != std::string::npos) text.replace(at, what.size(), with);
}

template <typename Number>
void append_number(Number number, std::string& text) {
  char digits[32];
  text.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
}

}  // namespace

void Labels::add_dof(Label label, bool is_actuated) {
  if (is_actuated) actuated.push_back(label);
  dofs.push_back(std::move(label));
}

const std::vector<Label>& Labels::of(v1::Axis axis) const {
  static const std::vector<Label> none;
  if (axis == v1::AXIS_DOF) return dofs;
  if (axis == v1::AXIS_ACTUATED) return actuated;
  return axis == v1::AXIS_COORDINATE ? coordinates : none;
}

std::string effort_unit(const std::string& position_unit) {
  return position_unit == "m" ? "N" : "N m";
}

std::string unit_of(const pb::FieldDescriptor& field, const Label& label) {
  std::string unit = field.options().GetExtension(v1::unit);
  replace(unit, "POSITION", label.unit);
  replace(unit, "EFFORT", effort_unit(label.unit));
  return unit;
}

std::vector<Leaf> leaves(const pb::Descriptor& message) {
  std::vector<Leaf> found;
  for (int i = 0; i < message.field_count(); ++i) {
    const pb::FieldDescriptor* const field = message.field(i);
    if (field->message_type() == nullptr) {
      found.push_back({field->name(), nullptr, field, field->options().GetExtension(v1::axis)});
      continue;
    }
    for (Leaf& leaf : leaves(*field->message_type())) {
      leaf.name = field->name() + "_" + leaf.name;
      leaf.parent = field;
      found.push_back(std::move(leaf));
    }
  }
  return found;
}

const pb::Message* holder(const pb::Message& message, const Leaf& leaf) {
  if (leaf.parent == nullptr) return &message;
  const pb::Reflection& reflection = *message.GetReflection();
  return reflection.HasField(message, leaf.parent) ? &reflection.GetMessage(message, leaf.parent)
                                                   : nullptr;
}

int count(const pb::Message& message, const Leaf& leaf) {
  const pb::Message* const held = holder(message, leaf);
  if (held == nullptr) return 0;
  return leaf.field->is_repeated() ? held->GetReflection()->FieldSize(*held, leaf.field) : 1;
}

void append_value(const pb::Message& held, const pb::FieldDescriptor& field, int index,
                  std::string& text) {
  const pb::Reflection& r = *held.GetReflection();
  const bool repeated = field.is_repeated();
  switch (field.cpp_type()) {
    case pb::FieldDescriptor::CPPTYPE_DOUBLE:
      return append_number(
          repeated ? r.GetRepeatedDouble(held, &field, index) : r.GetDouble(held, &field), text);
    case pb::FieldDescriptor::CPPTYPE_UINT64:
      return append_number(
          repeated ? r.GetRepeatedUInt64(held, &field, index) : r.GetUInt64(held, &field), text);
    case pb::FieldDescriptor::CPPTYPE_INT64:
      return append_number(
          repeated ? r.GetRepeatedInt64(held, &field, index) : r.GetInt64(held, &field), text);
    case pb::FieldDescriptor::CPPTYPE_ENUM:
      text += value_text(*field.enum_type(), repeated ? r.GetRepeatedEnumValue(held, &field, index)
                                                      : r.GetEnumValue(held, &field));
      return;
    case pb::FieldDescriptor::CPPTYPE_UINT32: {
      const std::uint32_t value =
          repeated ? r.GetRepeatedUInt32(held, &field, index) : r.GetUInt32(held, &field);
      if (!field.options().HasExtension(v1::bits)) return append_number(value, text);
      const std::size_t before = text.size();
      for (const std::string& name : bit_names(field, value)) {
        text += (text.size() == before ? "" : "|") + name;
      }
      return;
    }
    case pb::FieldDescriptor::CPPTYPE_INT32:
      return append_number(
          repeated ? r.GetRepeatedInt32(held, &field, index) : r.GetInt32(held, &field), text);
    case pb::FieldDescriptor::CPPTYPE_BOOL:
      text += (repeated ? r.GetRepeatedBool(held, &field, index) : r.GetBool(held, &field))
                  ? "true"
                  : "false";
      return;
    case pb::FieldDescriptor::CPPTYPE_STRING:
      text += repeated ? r.GetRepeatedString(held, &field, index) : r.GetString(held, &field);
      return;
    default:
      // A type that no field here has so far: the test of the schema names the field.
      text += '?';
  }
}

const char* value_name(const pb::EnumDescriptor& type, int number) {
  const pb::EnumValueDescriptor* const value = type.FindValueByNumber(number);
  if (value == nullptr) return nullptr;
  // "StalenessLevel" precedes its values as "STALENESS_LEVEL_": one more character per capital.
  const auto capitals = std::count_if(type.name().begin(), type.name().end(),
                                      [](unsigned char c) { return std::isupper(c) != 0; });
  const char* const name =
      value->name().c_str() + type.name().size() + static_cast<std::size_t>(capitals);
  return std::string_view(name) == "UNSPECIFIED" ? "NONE" : name;
}

std::string value_text(const pb::EnumDescriptor& type, int number) {
  const char* const name = value_name(type, number);
  return name == nullptr ? std::to_string(number) : name;
}

std::vector<std::string> bit_names(const pb::FieldDescriptor& field, std::uint32_t bits) {
  std::string_view known = field.options().GetExtension(v1::bits);
  std::vector<std::string> names;
  for (std::uint32_t bit = 0; bits >> bit != 0 && bit < 32; ++bit) {
    const std::string_view name = known.substr(0, known.find(' '));
    known.remove_prefix(std::min(known.size(), name.size() + 1));
    if ((bits >> bit & 1U) == 0) continue;
    names.push_back(name.empty() || name == "-" ? std::to_string(bit) : std::string(name));
  }
  return names;
}

std::vector<std::string> bit_words(const pb::FieldDescriptor& field, std::uint32_t bits) {
  std::vector<std::string> words;
  for (int bit = 0; bit < field.options().ExtensionSize(v1::words); ++bit) {
    if ((bits >> bit & 1U) != 0) words.push_back(field.options().GetExtension(v1::words, bit));
  }
  return words;
}

}  // namespace haptic::schema
