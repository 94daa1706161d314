#include "server/base/log.hpp"

#include <sched.h>
#include <spdlog/async.h>
#include <spdlog/details/null_mutex.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "haptic/wire/printable.hpp"
#include "server/base/thread_setup.hpp"

namespace haptic::server {
namespace {

std::string as_json(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

/// A flag of a line's pattern, by a function that writes its text.
class Flag final : public spdlog::custom_flag_formatter {
 public:
  using Text = std::function<std::string(const spdlog::details::log_msg& message)>;
  explicit Flag(Text text) : text_(std::move(text)) {}
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& line) override {
    const std::string text = text_(message);
    line.append(text.data(), text.data() + text.size());
  }
  [[nodiscard]] std::unique_ptr<spdlog::custom_flag_formatter> clone() const override {
    return std::make_unique<Flag>(text_);
  }

 private:
  const Text text_;
};

/// sd-daemon(3): "<3>" an error, "<4>" a warning, "<6>" information, "<7>" for debugging.
std::string syslog_priority(const spdlog::details::log_msg& message) {
  if (message.level >= spdlog::level::critical) return "<2>";
  if (message.level == spdlog::level::err) return "<3>";
  if (message.level == spdlog::level::warn) return "<4>";
  return message.level == spdlog::level::info ? "<6>" : "<7>";
}

constexpr std::size_t kMostLines = 1024;
constexpr std::chrono::milliseconds kPatienceAtExit{200};
constexpr std::chrono::milliseconds kLook{2};

/// Writes without the C library's stream, because exit() waits for the stream's lock and a thread
/// blocked in a write would hold it. Only the log's own thread calls.
class StderrSink final : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    spdlog::memory_buf_t line;
    formatter_->format(message, line);
    const char* next = line.data();
    const char* const end = next + line.size();
    while (next < end) {
      const ssize_t written = ::write(STDERR_FILENO, next, static_cast<std::size_t>(end - next));
      if (written <= 0) return;  // the reader has closed its end
      next += written;
    }
  }
  void flush_() override {}
};

std::atomic<pid_t> log_thread{0};

/// Never destroyed: the destructor would join a thread that may wait for a reader for ever.
std::shared_ptr<spdlog::details::thread_pool>& pool() {
  static auto* const lines = new std::shared_ptr<spdlog::details::thread_pool>(
      std::make_shared<spdlog::details::thread_pool>(kMostLines, 1, [] {
        // This thread starts before main blocks the signals; without a block of its own a signal
        // that main cannot take at once would end the process here.
        set_thread_up("haptic-log");
        log_thread.store(gettid());
      }));
  return *lines;
}

}  // namespace

std::unique_ptr<spdlog::formatter> log_formatter(LogFormat format, bool for_journal) {
  const std::string time = "%Y-%m-%dT%H:%M:%S.%e%z";
  std::string line = time + " %l %*";
  if (format == LogFormat::kJson) {
    line = R"({"time":")" + time + R"(","level":"%l","message":%*})";
  } else if (format == LogFormat::kBare) {
    line = "%&%*";
  }
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<Flag>('&', syslog_priority);
  formatter->add_flag<Flag>('*', [format](const spdlog::details::log_msg& message) {
    const std::string text(message.payload.data(), message.payload.size());
    return format == LogFormat::kJson ? as_json(text) : wire::printable(text);
  });
  formatter->set_pattern(for_journal ? "%&" + line : line);
  return formatter;
}

bool stderr_is_journal() {
  const char* const stream = std::getenv("JOURNAL_STREAM");  // "device:inode"
  struct stat status {};
  if (stream == nullptr || fstat(STDERR_FILENO, &status) != 0) return false;
  return std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino) == stream;
}

void log_to_stderr(LogFormat format) {
  spdlog::set_default_logger(
      std::make_shared<spdlog::async_logger>("hapticd", std::make_shared<StderrSink>(), pool(),
                                             spdlog::async_overflow_policy::overrun_oldest));
  spdlog::set_formatter(log_formatter(format, stderr_is_journal()));
}

void log_in_realtime() {
  const sched_param lowest{1};
  if (const pid_t thread = log_thread.load()) sched_setscheduler(thread, SCHED_FIFO, &lowest);
}

void finish_log() {
  const std::size_t dropped = pool()->overrun_counter();
  if (dropped > 0)
    spdlog::warn("{} lines of this log were lost: they were not read in time", dropped);
  // The flush is the last entry of the queue: when it has left, the lines before it are written.
  spdlog::default_logger()->flush();
  const auto give_up = std::chrono::steady_clock::now() + kPatienceAtExit;
  while (pool()->queue_size() > 0 && std::chrono::steady_clock::now() < give_up) {
    std::this_thread::sleep_for(kLook);
  }
}

}  // namespace haptic::server
