#include "server/front/metrics/exposition.hpp"

#include <charconv>

namespace haptic::server {
namespace {

/// The shortest text that reads back as the same double.
std::string number(double value) {
  char text[32];
  const auto format = value < 1e5 ? std::chars_format::general : std::chars_format::fixed;
  const auto end = std::to_chars(text, text + sizeof text, value, format).ptr;
  return {text, end};
}

/// Escapes a label's value: backslash, quote and line feed.
std::string escaped(std::string_view value) {
  std::string out;
  for (const char c : value) {
    if (c == '\n') {
      out += "\\n";
      continue;
    }
    if (c == '\\' || c == '"') out += '\\';
    out += c;
  }
  return out;
}

}  // namespace

void Exposition::family(std::string_view name, std::string_view type, std::string_view help) {
  name_ = name;
  text_.append("# HELP ").append(name).append(" ").append(help).append("\n");
  text_.append("# TYPE ").append(name).append(" ").append(type).append("\n");
}

void Exposition::line(std::string_view suffix, const Labels& labels, double value) {
  text_.append(name_).append(suffix);
  const char* separator = "{";
  for (const auto& [label, content] : labels) {
    text_.append(separator).append(label).append("=\"").append(escaped(content)).append("\"");
    separator = ",";
  }
  if (!labels.empty()) text_.append("}");
  text_.append(" ").append(number(value)).append("\n");
}

void Exposition::sample(const Labels& labels, const HistogramView& values) {
  std::uint64_t so_far = 0;
  for (std::size_t i = 0; i < values.counts.size(); ++i) {
    so_far += values.counts[i];
    const std::string bound =
        i < values.bounds.size() ? number(values.bounds[i]) : std::string("+Inf");
    Labels with_bound = labels;
    with_bound.emplace_back("le", bound);
    line("_bucket", with_bound, static_cast<double>(so_far));
  }
  line("_sum", labels, values.sum);
  line("_count", labels, static_cast<double>(so_far));
}

}  // namespace haptic::server
