#include "server/scene/override.hpp"

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/text_format.h>

#include <memory>

#include "haptic/core/error.hpp"
#include "server/scene/field_path.hpp"
#include "server/scene/text_format.hpp"

namespace haptic::server {

namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

class FirstError final : public google::protobuf::io::ErrorCollector {
 public:
  void AddError(int, int, const std::string& message) override {
    if (text.empty()) text = message;
  }
  std::string text{};
};

[[noreturn]] void refuse(const std::string& assignment, const std::string& why) {
  throw core::SceneError("--set " + assignment + ": " + why);
}

const FieldDescriptor& find(const Message& message, const FieldStep& step,
                            const std::string& assignment) {
  const FieldDescriptor* field = message.GetDescriptor()->FindFieldByName(step.name);
  if (step.malformed) refuse(assignment, "'" + step.name + "' must be name or name[number]");
  if (field == nullptr) {
    refuse(assignment, "no field '" + step.name +
                           "'; there are: " + fields_of(*message.GetDescriptor(), step.name));
  }
  if (step.index >= 0 && !field->is_repeated()) {
    refuse(assignment, "'" + step.name + "' is one value, not a list");
  }
  if (step.index < 0 && field->is_repeated()) {
    refuse(assignment, "'" + step.name + "' is a list: say which, " + step.name + "[0]");
  }
  if (field->is_repeated()) {
    const int size = message.GetReflection()->FieldSize(message, field);
    if (step.index > size) {
      refuse(assignment, step.name + "[" + std::to_string(step.index) + "]: the list has " +
                             std::to_string(size) + "; [" + std::to_string(size) + "] appends");
    }
  }
  return *field;
}

Message& descend(Message& message, const FieldStep& step, const std::string& assignment) {
  const FieldDescriptor& field = find(message, step, assignment);
  if (field.cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) {
    refuse(assignment, "'" + step.name + "' has no fields of its own");
  }
  const Reflection& reflection = *message.GetReflection();
  if (!field.is_repeated()) return *reflection.MutableMessage(&message, &field);
  return step.index == reflection.FieldSize(message, &field)
             ? *reflection.AddMessage(&message, &field)
             : *reflection.MutableRepeatedMessage(&message, &field, step.index);
}

/// Parses the value as the field's only one in a message of its own, so that a bad value changes
/// nothing.
std::unique_ptr<Message> parsed(const Message& like, const FieldDescriptor& field,
                                const std::string& value, const std::string& assignment) {
  std::unique_ptr<Message> holder(like.New());
  const bool bare_string = field.cpp_type() == FieldDescriptor::CPPTYPE_STRING &&
                           (value.empty() || (value.front() != '"' && value.front() != '\''));
  if (bare_string) {
    if (field.is_repeated()) {
      holder->GetReflection()->AddString(holder.get(), &field, value);
    } else {
      holder->GetReflection()->SetString(holder.get(), &field, value);
    }
    return holder;
  }
  FirstError error;
  google::protobuf::TextFormat::Parser parser;
  parser.RecordErrorsTo(&error);
  const bool message = field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
  const std::string text = field.name() + (message ? " " : ": ") + value;
  if (!parser.ParseFromString(text, holder.get())) {
    refuse(assignment, "'" + value + "' is not a " +
                           (message ? "message, as in { field: value }" : field.cpp_type_name()) +
                           std::string(": ") + error.text);
  }
  return holder;
}

void put(Message& message, const FieldStep& step, const std::string& value,
         const std::string& assignment) {
  const FieldDescriptor& field = find(message, step, assignment);
  const std::unique_ptr<Message> holder = parsed(message, field, value, assignment);
  const Reflection& reflection = *message.GetReflection();
  if (!field.is_repeated()) {
    reflection.ClearField(&message, &field);
    message.MergeFrom(*holder);
    return;
  }
  const int size = reflection.FieldSize(message, &field);
  message.MergeFrom(*holder);  // appends
  if (step.index < size) {
    reflection.SwapElements(&message, &field, step.index, size);
    reflection.RemoveLast(&message, &field);
  }
}

}  // namespace

void apply_override(const std::string& assignment, v1::Scene& scene) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    refuse(assignment, "must be path=value, as in loop.priority=50");
  }
  const std::vector<FieldStep> steps = split_path(assignment.substr(0, equals));
  v1::Scene changed = scene;
  Message* message = &changed;
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
    message = &descend(*message, steps[i], assignment);
  }
  put(*message, steps.back(), assignment.substr(equals + 1), assignment);
  scene = std::move(changed);
}

}  // namespace haptic::server
