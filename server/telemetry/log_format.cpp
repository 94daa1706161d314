#include "server/telemetry/log_format.hpp"

#include <spdlog/pattern_formatter.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

namespace haptic::server {
namespace {

std::string as_json(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// "\x0a" for each control character; everything else, a backslash too, stays readable as it is.
std::string as_line(const std::string& text) {
  static constexpr const char* kDigits = "0123456789abcdef";
  std::string line;
  line.reserve(text.size());
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte != 0x7f) {
      line += c;
    } else {
      line += {'\\', 'x', kDigits[byte >> 4U], kDigits[byte & 15U]};
    }
  }
  return line;
}

class EscapedMessage final : public spdlog::custom_flag_formatter {
 public:
  explicit EscapedMessage(LogFormat format) : format_(format) {}
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& line) override {
    const std::string text(message.payload.data(), message.payload.size());
    const std::string escaped = format_ == LogFormat::kJson ? as_json(text) : as_line(text);
    line.append(escaped.data(), escaped.data() + escaped.size());
  }
  [[nodiscard]] std::unique_ptr<spdlog::custom_flag_formatter> clone() const override {
    return std::make_unique<EscapedMessage>(format_);
  }

 private:
  LogFormat format_;
};

/// sd-daemon(3): "<3>" an error, "<4>" a warning, "<6>" information, "<7>" for debugging.
class SyslogPriority final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& line) override {
    const char digit = message.level >= spdlog::level::critical ? '2'
                       : message.level == spdlog::level::err    ? '3'
                       : message.level == spdlog::level::warn   ? '4'
                       : message.level == spdlog::level::info   ? '6'
                                                                : '7';
    for (const char c : {'<', digit, '>'}) line.push_back(c);
  }
  [[nodiscard]] std::unique_ptr<spdlog::custom_flag_formatter> clone() const override {
    return std::make_unique<SyslogPriority>();
  }
};

}  // namespace

std::unique_ptr<spdlog::formatter> log_formatter(LogFormat format, bool for_journal) {
  const std::string time = "%Y-%m-%dT%H:%M:%S.%e%z";
  const std::string line = format == LogFormat::kJson
                               ? R"({"time":")" + time + R"(","level":"%l","message":%*})"
                               : time + " %l %*";
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<SyslogPriority>('&');
  formatter->add_flag<EscapedMessage>('*', format);
  formatter->set_pattern(for_journal ? "%&" + line : line);
  return formatter;
}

bool stderr_is_journal() {
  const char* const stream = std::getenv("JOURNAL_STREAM");  // "device:inode"
  struct stat status {};
  if (stream == nullptr || fstat(STDERR_FILENO, &status) != 0) return false;
  return std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino) == stream;
}

}  // namespace haptic::server
