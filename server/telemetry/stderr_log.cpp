#include "server/telemetry/stderr_log.hpp"

#include <spdlog/async.h>
#include <spdlog/details/null_mutex.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <memory>
#include <thread>

#include "server/base/thread_setup.hpp"

namespace haptic::server {
namespace {

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

/// Never destroyed: the destructor would join a thread that may wait for a reader for ever.
std::shared_ptr<spdlog::details::thread_pool>& pool() {
  static auto* const lines = new std::shared_ptr<spdlog::details::thread_pool>(
      std::make_shared<spdlog::details::thread_pool>(kMostLines, 1, [] {
        // This thread starts before main blocks the signals; without a block of its own a signal
        // that main cannot take at once would end the process here.
        set_thread_up("haptic-log");
      }));
  return *lines;
}

}  // namespace

void log_to_stderr(LogFormat format) {
  spdlog::set_default_logger(
      std::make_shared<spdlog::async_logger>("hapticd", std::make_shared<StderrSink>(), pool(),
                                             spdlog::async_overflow_policy::overrun_oldest));
  spdlog::set_formatter(log_formatter(format, stderr_is_journal()));
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
