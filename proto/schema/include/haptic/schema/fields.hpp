#pragma once
/// Names, labels, units and text of a message's fields, read from its descriptor and the options of
/// haptic/v1/field_options.proto. Code that prints a message through this shows a new field at
/// once.

#include <cstdint>
#include <string>
#include <vector>

#include "google/protobuf/descriptor.h"
#include "google/protobuf/message.h"
#include "haptic/v1/field_options.pb.h"

namespace haptic::schema {

/// One DoF or virtual coordinate of a device.
struct Label {
  std::string name{};
  std::string unit{};  ///< of its position: "m", "rad" or "1"
};

/// The axes of a device, in the order of ListDevices.
struct Labels {
  std::vector<Label> dofs{}, actuated{}, coordinates{};

  /// Also into `actuated` if it is.
  void add_dof(Label label, bool is_actuated);
  [[nodiscard]] const std::vector<Label>& of(v1::Axis axis) const;
};

/// "N" or "N m": the effort on a coordinate whose position has this unit.
[[nodiscard]] std::string effort_unit(const std::string& position_unit);

/// "us", "N m/rad"; empty: none. `label` is of the value, if the field has an axis.
[[nodiscard]] std::string unit_of(const google::protobuf::FieldDescriptor& field,
                                  const Label& label = {});

/// A field that holds values: of the message itself, or of a message in it.
struct Leaf {
  std::string name{};  ///< as in the .proto; "passivity_tank" of `tank` in `passivity`
  const google::protobuf::FieldDescriptor* parent{nullptr};  ///< "passivity"; null: none
  const google::protobuf::FieldDescriptor* field{nullptr};
  v1::Axis axis{v1::AXIS_UNSPECIFIED};
};

/// In the order of declaration. No message in it may be repeated.
[[nodiscard]] std::vector<Leaf> leaves(const google::protobuf::Descriptor& message);
/// The message that holds the leaf's field; null: it is absent.
[[nodiscard]] const google::protobuf::Message* holder(const google::protobuf::Message& message,
                                                      const Leaf& leaf);
/// Number of values: 0 or 1 of a field that is not repeated.
[[nodiscard]] int count(const google::protobuf::Message& message, const Leaf& leaf);
/// Value `index` of the field as text without commas: a number that reads back to the same bits,
/// the name of an enum's value, the names of set bits joined by '|'. Not of a message.
void append_value(const google::protobuf::Message& holder,
                  const google::protobuf::FieldDescriptor& field, int index, std::string& text);

/// "ENGAGED" of DEVICE_STATE_NAME_ENGAGED; "NONE" of an UNSPECIFIED; null: not known here. Lives as
/// long as the program.
[[nodiscard]] const char* value_name(const google::protobuf::EnumDescriptor& type, int number);
/// The same; an unknown value is its number, for a newer server has more of them.
[[nodiscard]] std::string value_text(const google::protobuf::EnumDescriptor& type, int number);
/// Names of the bits that are set; a bit without a name is its number.
[[nodiscard]] std::vector<std::string> bit_names(const google::protobuf::FieldDescriptor& field,
                                                 std::uint32_t bits);
/// Sentences for people of the bits that are set; none of a bit that is not known.
[[nodiscard]] std::vector<std::string> bit_words(const google::protobuf::FieldDescriptor& field,
                                                 std::uint32_t bits);

}  // namespace haptic::schema
