#include "server/owner/scene/problems.hpp"

#include <google/protobuf/stubs/strutil.h>

#include <algorithm>
#include <charconv>
#include <regex>

#include "haptic/core/error.hpp"
#include "haptic/wire/utf8.hpp"

namespace haptic::server {
namespace {

using google::protobuf::FieldDescriptor;

constexpr std::size_t kLongestQuote = 80;

/// Line of a field in its message, from 1; 0 if it is not in the file. protobuf keeps one line for
/// all of `[1, 2, 3]`, so an element without its own line gets that of the list.
int line_in(const Problems::Tree& tree, const FieldDescriptor& field, int index) {
  if (!field.is_repeated()) return tree.GetLocation(&field, -1).line + 1;
  const int own = tree.GetLocation(&field, std::max(index, 0)).line;
  return (own >= 0 || field.message_type() != nullptr ? own : tree.GetLocation(&field, 0).line) + 1;
}

/// `inner` is the field `outer` itself, or inside it.
bool stands_within(const FieldPath& inner, const FieldPath& outer) {
  if (inner.size() < outer.size()) return false;
  return std::equal(outer.begin(), outer.end(), inner.begin(),
                    [](const FieldStep& o, const FieldStep& i) {
                      return o.name == i.name && (o.index < 0 || o.index == i.index);
                    });
}

}  // namespace

std::string text(const FieldPath& path) {
  std::string all;
  for (const FieldStep& step : path) {
    all += (all.empty() ? "" : ".") + step.name;
    if (step.index >= 0) all += "[" + std::to_string(step.index) + "]";
  }
  return all;
}

/// The field's line, or that of the nearest message around it that is in the file.
std::string Problems::place_of(const FieldPath& path) const {
  const auto overridden = [&](auto&& by) {
    return std::any_of(overrides_.begin(), overrides_.end(), by);
  };
  if (overridden([&](const FieldPath& set) { return stands_within(path, set); })) {
    return "--set: ";
  }
  const google::protobuf::Descriptor* type = &root_;
  const Tree* tree = &tree_;
  int line = 0;
  FieldPath walked;
  for (const FieldStep& step : path) {
    walked.push_back(step);
    const FieldDescriptor* field = type->FindFieldByName(step.name);
    const int own = field == nullptr ? 0 : line_in(*tree, *field, step.index);
    if (own == 0) {
      if (overridden([&](const FieldPath& set) { return stands_within(set, walked); })) {
        return "--set: ";
      }
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

void Problems::wrong(const FieldPath& path, const std::string& value, const std::string& rule) {
  add(told() ? place_of(path) + text(path) + " = " + value + ": " + rule : "");
}

void Problems::missing(const FieldPath& path, const std::string& rule) {
  add(told() ? place_of(path) + text(path) + ": is required: " + rule : "");
}

void Problems::add(std::string line) {
  ++count_;
  if (told()) lines_.push_back(std::move(line));
}

void Problems::advise(const std::string& instead) {
  if (told() && !lines_.empty()) lines_.back() += ": " + instead;
}

void Problems::raise() const {
  if (count_ == 0) return;
  std::string all;
  for (const std::string& line : lines_) all += (all.empty() ? "" : "\n") + line;
  if (count_ > lines_.size()) {
    all += "\n" + name_ + ": and " + std::to_string(count_ - lines_.size()) + " more";
  }
  throw core::SceneError(all);
}

std::string decimal(double value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

std::string quoted(const std::string& text) {
  const bool long_text = text.size() > kLongestQuote;
  const std::string shown = text.substr(0, kLongestQuote);
  // Invalid UTF-8, for example after the cut, is escaped byte by byte.
  const std::string escaped = wire::is_utf8(shown)
                                  ? google::protobuf::strings::Utf8SafeCEscape(shown)
                                  : google::protobuf::CEscape(shown);
  return '"' + escaped + (long_text ? "...\"" : "\"");
}

bool matches(const std::string& text, const std::string& pattern) {
  // std::regex needs stack for each character that it compares.
  return text.size() <= 1024 && std::regex_match(text, std::regex(pattern));
}

}  // namespace haptic::server
