#include "message_json.hpp"

#include "google/protobuf/duration.pb.h"
#include "google/protobuf/util/time_util.h"
#include "haptic/schema/fields.hpp"

namespace haptic::ctl {
namespace {

namespace pb = google::protobuf;
using nlohmann::json;

bool is_duration(const pb::FieldDescriptor& field) {
  return field.message_type() == pb::Duration::descriptor();
}

/// `index` counts for a repeated field only.
json value_of(const pb::Message& held, const pb::FieldDescriptor& field, int index) {
  const pb::Reflection& r = *held.GetReflection();
  if (field.message_type() != nullptr) {
    const pb::Message& message = field.is_repeated() ? r.GetRepeatedMessage(held, &field, index)
                                                     : r.GetMessage(held, &field);
    if (!is_duration(field)) return to_json(message);
    pb::Duration duration;
    duration.CopyFrom(message);
    return 1e-3 * static_cast<double>(pb::util::TimeUtil::DurationToNanoseconds(duration));
  }
  if (field.options().HasExtension(v1::bits)) {
    return schema::bit_names(field, field.is_repeated() ? r.GetRepeatedUInt32(held, &field, index)
                                                        : r.GetUInt32(held, &field));
  }
  std::string text;
  schema::append_value(held, field, index, text);
  if (field.enum_type() != nullptr || field.type() == pb::FieldDescriptor::TYPE_STRING) return text;
  json number = json::parse(text, nullptr, false);
  return number.is_discarded() ? json() : number;  // JSON has no nan
}

}  // namespace

json to_json(const pb::Message& message) {
  const pb::Reflection& r = *message.GetReflection();
  json object = json::object();
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    const pb::FieldDescriptor& field = *message.GetDescriptor()->field(i);
    json& value = object[field.name() + (is_duration(field) ? "_us" : "")];
    if (field.is_repeated()) {
      value = json::array();
      for (int k = 0; k < r.FieldSize(message, &field); ++k) {
        value.push_back(value_of(message, field, k));
      }
    } else if (field.message_type() == nullptr || r.HasField(message, &field)) {
      value = value_of(message, field, 0);
    }
  }
  return object;
}

}  // namespace haptic::ctl
