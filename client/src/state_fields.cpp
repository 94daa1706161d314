#include "haptic/client/state_fields.hpp"

#include "convert_state.hpp"
#include "haptic/schema/fields.hpp"
#include "haptic/v1/session.pb.h"

namespace haptic::client {
namespace {

namespace pb = google::protobuf;

StateField::Kind kind_of(const pb::FieldDescriptor& field) {
  if (field.message_type() != nullptr) return StateField::Kind::kMessage;
  if (field.enum_type() != nullptr) return StateField::Kind::kName;
  return field.options().HasExtension(v1::bits) ? StateField::Kind::kBits
                                                : StateField::Kind::kNumber;
}

const char* axis_name(v1::Axis axis) {
  if (axis == v1::AXIS_DOF) return "dof";
  if (axis == v1::AXIS_ACTUATED) return "actuated";
  return axis == v1::AXIS_COORDINATE ? "coordinate" : "";
}

std::vector<StateField> fields_of(const pb::Message& message, const schema::Labels& labels,
                                  bool absent = false) {
  const pb::Reflection& reflection = *message.GetReflection();
  std::vector<StateField> fields;
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const pb::FieldDescriptor& descriptor = *message.GetDescriptor()->field(i);
    const v1::Axis axis = descriptor.options().GetExtension(v1::axis);
    StateField field;
    field.name = descriptor.name();
    field.kind = kind_of(descriptor);
    field.repeated = descriptor.is_repeated();
    field.axis = axis_name(axis);
    for (const schema::Label& label : labels.of(axis)) {
      field.labels.push_back(label.name);
      field.units.push_back(schema::unit_of(descriptor, label));
    }
    if (axis == v1::AXIS_UNSPECIFIED) field.units.push_back(schema::unit_of(descriptor));
    const int count = field.repeated ? reflection.FieldSize(message, &descriptor) : absent ? 0 : 1;
    for (int k = 0; k < count && field.kind != StateField::Kind::kMessage; ++k) {
      schema::append_value(message, descriptor, k, field.values.emplace_back());
    }
    if (field.kind == StateField::Kind::kMessage && field.repeated) {
      for (int k = 0; k < count; ++k) {
        field.messages.push_back(
            fields_of(reflection.GetRepeatedMessage(message, &descriptor, k), labels));
      }
    } else if (field.kind == StateField::Kind::kMessage) {
      field.messages.push_back(fields_of(reflection.GetMessage(message, &descriptor), labels,
                                         !reflection.HasField(message, &descriptor)));
    }
    fields.push_back(std::move(field));
  }
  return fields;
}

}  // namespace

std::vector<StateField> state_fields(const DeviceInfo& device, const DeviceState& state) {
  schema::Labels labels;
  for (const DegreeOfFreedom& dof : device.dofs) labels.add_dof({dof.name, dof.unit}, dof.actuated);
  for (const VirtualCoordinate& c : device.coordinates)
    labels.coordinates.push_back({c.name, c.unit});
  v1::DeviceState message;
  write(state, message);
  return fields_of(message, labels);
}

}  // namespace haptic::client
