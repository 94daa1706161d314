#include "server/scene/problems.hpp"

#include <charconv>

#include "haptic/core/error.hpp"
#include "server/scene/field_path.hpp"

namespace haptic::server {

std::string decimal(double value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

int Problems::line_of(const std::string& path) const {
  const google::protobuf::Descriptor* type = &root_;
  const google::protobuf::TextFormat::ParseInfoTree* tree = &tree_;
  int line = 0;
  for (const FieldStep& step : split_path(path)) {
    const google::protobuf::FieldDescriptor* field =
        type != nullptr ? type->FindFieldByName(step.name) : nullptr;
    if (field == nullptr || tree == nullptr) break;
    // protobuf checks the index of singular fields too: -1 is theirs.
    const int index = field->is_repeated() ? std::max(step.index, 0) : -1;
    const auto location = tree->GetLocation(field, index);
    if (location.line < 0) break;
    line = location.line + 1;
    if (field->cpp_type() != google::protobuf::FieldDescriptor::CPPTYPE_MESSAGE) break;
    tree = tree->GetTreeForNested(field, index);
    type = field->message_type();
  }
  return line;
}

void Problems::add(const std::string& path, const std::string& value, const std::string& allowed) {
  const int line = line_of(path);
  lines_.push_back(name_ + (line > 0 ? ":" + std::to_string(line) : "") + ": " + path + " = " +
                   value + ": " + allowed);
}

void Problems::add(const std::string& path, double value, const std::string& allowed) {
  add(path, decimal(value), allowed);
}

void Problems::missing(const std::string& path, const std::string& wanted) {
  const int line = line_of(path);
  lines_.push_back(name_ + (line > 0 ? ":" + std::to_string(line) : "") + ": " + path +
                   ": missing; " + wanted);
}

void Problems::raise() const {
  if (lines_.empty()) return;
  std::string all;
  for (const std::string& line : lines_) all += (all.empty() ? "" : "\n") + line;
  throw core::SceneError(all);
}

}  // namespace haptic::server
