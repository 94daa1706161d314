#include "server/owner/scene/text.hpp"

#include <google/protobuf/io/tokenizer.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include <algorithm>
#include <optional>

#include "haptic/core/error.hpp"
#include "server/owner/scene/removed.hpp"

namespace haptic::server {
namespace {

namespace io = google::protobuf::io;
using google::protobuf::TextFormat;

struct UnknownField {
  std::string type{};  ///< "haptic.v1.ImpedanceScene"
  std::string name{};
};

/// Reads protobuf's `Message type "T" has no field named "F".`
std::optional<UnknownField> unknown_field(const std::string& message) {
  const std::string before = "Message type \"", between = "\" has no field named \"";
  const std::size_t middle = message.find(between);
  if (message.rfind(before, 0) != 0 || middle == std::string::npos) return std::nullopt;
  const std::size_t name = middle + between.size();
  return UnknownField{message.substr(before.size(), middle - before.size()),
                      message.substr(name, message.find('"', name) - name)};
}

std::string explained(const std::string& message) {
  const auto unknown = unknown_field(message);
  if (!unknown) return message;
  const auto* type =
      google::protobuf::DescriptorPool::generated_pool()->FindMessageTypeByName(unknown->type);
  if (type == nullptr) return message;
  return unknown->name + ": unknown field; allowed here: " + fields_of(*type, unknown->name);
}

/// Offset of a token that protobuf places at `line` and `column`, both from 0. protobuf counts a
/// tab as up to eight columns; editors, and our messages, count one.
std::size_t offset_of(const std::string& text, int line, int column) {
  constexpr int kTab = 8;
  std::size_t at = 0;
  for (; line > 0 && at < text.size(); ++at) line -= text[at] == '\n' ? 1 : 0;
  for (int reached = 0; reached < column && at < text.size() && text[at] != '\n'; ++at) {
    reached += text[at] == '\t' ? kTab - reached % kTab : 1;
  }
  return at;
}

std::string line_and_column(const std::string& text, std::size_t offset) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(offset);
  const auto lines = std::count(text.begin(), end, '\n');
  const std::size_t start = lines == 0 ? 0 : text.rfind('\n', offset - 1) + 1;
  return std::to_string(lines + 1) + ":" + std::to_string(offset - start + 1);
}

/// The end of the comment or quoted text that begins at `at`.
std::size_t end_of_opaque(const std::string& text, std::size_t at) {
  const char closing = text[at] == '#' ? '\n' : text[at];
  for (++at; at < text.size() && text[at] != closing && text[at] != '\n'; ++at) {
    if (closing != '\n' && text[at] == '\\') ++at;
  }
  return at;
}

/// Offsets of the brackets that no other one closes, outermost first. It stops at a depth that no
/// scene has: the parser does not count the depth of what it skips.
std::vector<std::size_t> open_brackets(const std::string& text) {
  std::vector<std::size_t> open;
  for (std::size_t at = 0; at < text.size() && open.size() <= 2 * kDeepestNesting; ++at) {
    const char c = text[at];
    if (c == '#' || c == '"' || c == '\'') at = end_of_opaque(text, at);
    if (c == '{' || c == '<' || c == '[') open.push_back(at);
    if ((c == '}' || c == '>' || c == ']') && !open.empty()) open.pop_back();
  }
  return open;
}

/// Leaves the errors of a text to its parser.
struct Unheard final : io::ErrorCollector {
  void AddError(int /*line*/, int /*column*/, const std::string& /*message*/) override {}
};

/// protobuf's errors in a text, with our positions.
class Collector final : public io::ErrorCollector {
 public:
  Collector(const std::string& text, const std::string& name) : text_(text), name_(name) {}

  void AddError(int line, int column, const std::string& message) override {
    if (full()) return;
    const std::vector<std::size_t> open = open_brackets(text_);
    const bool at_the_end = message.ends_with("got: ") || message.ends_with("found \"\".");
    errors.push_back(at(offset_of(text_, line, column)) +
                     (at_the_end && !open.empty() ? missing(open.back()) : explained(message)));
  }
  /// Unknown fields: the parser skips them, so that all are found. It warns after it has read the
  /// token behind the name, so the name is searched backwards.
  void AddWarning(int line, int column, const std::string& message) override {
    if (full()) return;
    std::size_t offset = offset_of(text_, line, column);
    if (const auto unknown = unknown_field(message); unknown && offset > 0) {
      const std::size_t name = text_.rfind(unknown->name, offset - 1);
      if (name != std::string::npos) offset = name;
    }
    unknown_fields.push_back(at(offset) + explained(message));
  }
  /// Adds the removed fields to the unknown ones: the parser skips them too, without a warning.
  void find_removed_fields() {
    io::ArrayInputStream stream(text_.data(), static_cast<int>(text_.size()));
    Unheard unheard;
    io::Tokenizer tokenizer(&stream, &unheard);
    tokenizer.set_comment_style(io::Tokenizer::SH_COMMENT_STYLE);
    while (tokenizer.Next()) {
      const io::Tokenizer::Token& token = tokenizer.current();
      if (token.type != io::Tokenizer::TYPE_IDENTIFIER) continue;
      const std::string advice = removed_field(token.text);
      if (advice.empty() || full()) continue;
      unknown_fields.push_back(at(offset_of(text_, token.line, token.column)) + advice);
    }
  }

  std::vector<std::string> errors{};
  std::vector<std::string> unknown_fields{};
  std::size_t untold{0};

 private:
  /// Number of mistakes that a reader may want to see; to find the place of one takes as long as
  /// the text is.
  [[nodiscard]] bool full() {
    if (errors.size() + unknown_fields.size() < Problems::kMostTold) return false;
    ++untold;
    return true;
  }
  [[nodiscard]] std::string at(std::size_t offset) const {
    return name_ + ":" + line_and_column(text_, offset) + ": ";
  }
  /// Names the bracket that closes the one at `open`.
  [[nodiscard]] std::string missing(std::size_t open) const {
    const char opening = text_[open];
    const char closing = opening == '{' ? '}' : opening == '[' ? ']' : '>';
    const std::string place = line_and_column(text_, open);
    return std::string("a ") + closing + " is missing, for the " + opening + " of line " +
           place.substr(0, place.find(':')) + " or for one within it";
  }
  const std::string& text_;
  const std::string& name_;
};

void check_size_and_nesting(const std::string& text, const std::string& name) {
  if (text.size() > kLargestScene) {
    throw core::SceneError(name + ": has more than " + std::to_string(kLargestScene) +
                           " bytes, the most that a scene may have");
  }
  if (open_brackets(text).size() > 2 * kDeepestNesting)
    throw core::SceneError(name + ": its messages are nested too deeply");
}

}  // namespace

std::string fields_of(const google::protobuf::Descriptor& type, const std::string& wanted) {
  const auto alike = [&](const std::string& name) {
    const auto ends = std::mismatch(name.begin(), name.end(), wanted.begin(), wanted.end());
    return ends.first - name.begin();
  };
  std::vector<std::string> names;
  for (int i = 0; i < type.field_count(); ++i) names.push_back(type.field(i)->name());
  std::stable_sort(names.begin(), names.end(),
                   [&](const std::string& a, const std::string& b) { return alike(a) > alike(b); });
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all.empty() ? "no fields" : all;
}

void parse_text(const std::string& text, const std::string& name, v1::Scene& message,
                Problems::Tree& tree, Problems& problems) {
  check_size_and_nesting(text, name);
  Collector collector(text, name);
  TextFormat::Parser parser;
  parser.RecordErrorsTo(&collector);
  parser.WriteLocationsTo(&tree);
  parser.AllowUnknownField(true);
  parser.SetRecursionLimit(kDeepestNesting);
  const bool parsed = parser.ParseFromString(text, &message);
  collector.find_removed_fields();
  for (std::string& line : collector.unknown_fields) problems.add(std::move(line));
  for (std::string& line : collector.errors) problems.add(std::move(line));
  problems.add_untold(collector.untold);
  if (!parsed && collector.errors.empty()) problems.add(name + ": is no textproto");
  if (!parsed) problems.raise();
}

std::string parse_fragment(const std::string& text, google::protobuf::Message& message) {
  if (text.size() > kLargestScene || open_brackets(text).size() > 2 * kDeepestNesting)
    return "too long or too deeply nested";
  const std::string name = "value";
  Collector collector(text, name);
  TextFormat::Parser parser;
  parser.RecordErrorsTo(&collector);
  parser.SetRecursionLimit(kDeepestNesting);
  const bool parsed = parser.ParseFromString(text, &message);
  collector.find_removed_fields();
  const auto& wrong = parsed ? collector.unknown_fields : collector.errors;
  if (wrong.empty()) return parsed ? "" : "is no textproto";
  const std::string& first = wrong.front();
  return first.substr(first.find(": ") + 2);  // without the position within the value
}

}  // namespace haptic::server
