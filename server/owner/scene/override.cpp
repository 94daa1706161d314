// --set: see apply_override() in text.hpp.
#include <google/protobuf/stubs/strutil.h>

#include <algorithm>
#include <memory>
#include <regex>
#include <vector>

#include "haptic/core/error.hpp"
#include "server/owner/scene/problems.hpp"
#include "server/owner/scene/removed.hpp"
#include "server/owner/scene/text.hpp"

namespace haptic::server {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

[[noreturn]] void refuse(const std::string& why) {
  throw core::SceneError(why);
}

/// A step is name or name[number], the number with at most six digits.
FieldStep step_of(const std::string& word) {
  static const std::regex form(R"((\w{1,64})(\[(\d{1,6})\])?)");
  std::smatch parts;
  if (!std::regex_match(word, parts, form)) refuse("'" + word + "': must be name or name[number]");
  return parts[3].matched ? FieldStep(parts[1], std::stoul(parts[3])) : FieldStep(parts[1].str());
}

/// At least one step, whatever the text.
FieldPath path_of(const std::string& text) {
  FieldPath steps;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t dot = std::min(text.find('.', from), text.size());
    steps.push_back(step_of(text.substr(from, dot - from)));
    from = dot + 1;
  }
  return steps;
}

std::string wanted(const FieldDescriptor& field) {
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return "a message { field: value ... } with " + fields_of(*field.message_type(), "");
    case FieldDescriptor::CPPTYPE_STRING:
      return "text";
    case FieldDescriptor::CPPTYPE_BOOL:
      return "true or false";
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return "a number";
    case FieldDescriptor::CPPTYPE_UINT32:
    case FieldDescriptor::CPPTYPE_UINT64:
      return "a whole number >= 0";
    default:
      return "a whole number";
  }
}

const FieldDescriptor& find(const Message& message, const FieldStep& step) {
  const google::protobuf::Descriptor& type = *message.GetDescriptor();
  const FieldDescriptor* field = type.FindFieldByName(step.name);
  if (field == nullptr) {
    if (const std::string advice = removed_field(step.name); !advice.empty()) refuse(advice);
    refuse("'" + step.name + "': no such field; there are: " + fields_of(type, step.name));
  }
  if (step.index < 0) return *field;
  if (!field->is_repeated()) {
    refuse("'" + text({step}) + "': " + step.name + " is no list, leave the index out");
  }
  const int size = message.GetReflection()->FieldSize(message, field);
  if (step.index > size) {
    refuse("'" + text({step}) + "': the list has " + std::to_string(size) + "; " + step.name + "[" +
           std::to_string(size) + "] would append");
  }
  return *field;
}

/// The message that `step` leads to, created if it is absent.
Message& descend(Message& message, const FieldStep& step) {
  const FieldDescriptor& field = find(message, step);
  if (field.message_type() == nullptr)
    refuse("'" + text({step}) + "': is a value, it has no fields of its own");
  const google::protobuf::Reflection& reflection = *message.GetReflection();
  if (!field.is_repeated()) return *reflection.MutableMessage(&message, &field);
  if (step.index < 0) {
    refuse("'" + text({step}) + "': is a list, say which one: " + step.name + "[0]");
  }
  if (step.index == reflection.FieldSize(message, &field)) {
    return *reflection.AddMessage(&message, &field);
  }
  return *reflection.MutableRepeatedMessage(&message, &field, step.index);
}

/// The value as the only field of a message like `like`.
std::unique_ptr<Message> parsed(const Message& like, const FieldDescriptor& field, bool whole_list,
                                const std::string& value) {
  std::unique_ptr<Message> holder(like.New());
  const char first = value.empty() ? ' ' : value.front();
  const bool bare = field.cpp_type() == FieldDescriptor::CPPTYPE_STRING && first != '"' &&
                    first != '\'' && !(whole_list && first == '[');
  const std::string text = bare ? '"' + google::protobuf::CEscape(value) + '"' : value;
  const std::string why = parse_fragment(field.name() + ": " + text, *holder);
  if (!why.empty()) {
    refuse(quoted(value) + ": must be " + wanted(field) + (whole_list ? ", or a list" : "") + " (" +
           why + ")");
  }
  std::vector<const FieldDescriptor*> found;
  const google::protobuf::Reflection& reflection = *holder->GetReflection();
  reflection.ListFields(*holder, &found);
  const bool others = found.size() > 1 || (found.size() == 1 && found.front() != &field);
  const bool several =
      field.is_repeated() && !whole_list && reflection.FieldSize(*holder, &field) != 1;
  if (others || several) refuse(quoted(value) + ": must be one value, " + wanted(field));
  return holder;
}

void assign(Message& message, const FieldStep& step, const std::string& value) {
  const FieldDescriptor& field = find(message, step);
  const bool whole_list = field.is_repeated() && step.index < 0;
  const std::unique_ptr<Message> holder = parsed(message, field, whole_list, value);
  const google::protobuf::Reflection& reflection = *message.GetReflection();
  if (!field.is_repeated() || whole_list) {
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

FieldPath apply_override(const std::string& assignment, v1::Scene& scene) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    refuse("must be path=value, as in loop.priority=50");
  }
  const FieldPath steps = path_of(assignment.substr(0, equals));
  v1::Scene changed = scene;
  Message* message = &changed;
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) message = &descend(*message, steps[i]);
  assign(*message, steps.back(), assignment.substr(equals + 1));
  scene = std::move(changed);
  return steps;
}

}  // namespace haptic::server
