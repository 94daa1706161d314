#include "server/scene/problems.hpp"

#include <google/protobuf/stubs/strutil.h>

#include <algorithm>
#include <charconv>

#include "haptic/core/error.hpp"
#include "haptic/wire/utf8.hpp"
#include "server/scene/field_path.hpp"

namespace haptic::server {
namespace {

using google::protobuf::FieldDescriptor;

constexpr std::size_t kLongestQuote = 80;

/// Line of a field in its message, from 1; 0 where it is not in the file.
/// protobuf keeps one line for all of `[1, 2, 3]`, so an element without a line
/// of its own stands on its list's.
int line_in(const Problems::Tree& tree, const FieldDescriptor& field, int index) {
  if (!field.is_repeated()) return tree.GetLocation(&field, -1).line + 1;
  const int own = tree.GetLocation(&field, std::max(index, 0)).line;
  return (own >= 0 || field.message_type() != nullptr ? own : tree.GetLocation(&field, 0).line) + 1;
}

}  // namespace

bool Problems::overridden_at_or_below(const std::string& path) const {
  return std::any_of(overrides_.begin(), overrides_.end(),
                     [&](const std::string& set) { return stands_within(set, path); });
}

/// The field's line, or that of the nearest message around it that stands in
/// the file.
std::string Problems::place_of(const std::string& path) const {
  const bool replaced =
      std::any_of(overrides_.begin(), overrides_.end(),
                  [&](const std::string& set) { return stands_within(path, set); });
  if (replaced) return "--set: ";
  const google::protobuf::Descriptor* type = &root_;
  const Tree* tree = &tree_;
  int line = 0;
  std::string walked;
  for (const FieldStep& step : split_path(path)) {
    walked += (walked.empty() ? "" : ".") + step.text;
    const FieldDescriptor* field = type->FindFieldByName(step.name);
    const int own = field == nullptr ? 0 : line_in(*tree, *field, step.index);
    if (own == 0) {
      if (overridden_at_or_below(walked)) return "--set: ";
      break;
    }
    line = own;
    if (field->message_type() == nullptr) break;
    if (field->is_repeated() && step.index < 0) break;  // the list as a whole: its first element
    tree = tree->GetTreeForNested(field, step.index);
    type = field->message_type();
    if (tree == nullptr) break;
  }
  return name_ + (line > 0 ? ":" + std::to_string(line) : "") + ": ";
}

void Problems::wrong(const std::string& path, const std::string& value, const std::string& rule) {
  add(place_of(path) + path + " = " + value + ": " + rule);
}

void Problems::missing(const std::string& path, const std::string& rule) {
  add(place_of(path) + path + ": is required: " + rule);
}

void Problems::raise() const {
  std::string all;
  for (const std::string& line : lines_) all += (all.empty() ? "" : "\n") + line;
  if (any()) throw core::SceneError(all);
}

std::string decimal(double value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

std::string quoted(const std::string& text) {
  const bool long_text = text.size() > kLongestQuote;
  const std::string shown = text.substr(0, kLongestQuote);
  // Bytes that are no character, be it by the cut, stand as numbers.
  const std::string escaped = wire::is_utf8(shown)
                                  ? google::protobuf::strings::Utf8SafeCEscape(shown)
                                  : google::protobuf::CEscape(shown);
  return '"' + escaped + (long_text ? "...\"" : "\"");
}

}  // namespace haptic::server
