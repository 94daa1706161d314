#include "server/telemetry/stderr_log.hpp"

#include <spdlog/async.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <memory>
#include <thread>

namespace haptic::server {
namespace {

constexpr std::size_t kMostLines = 1024;
constexpr std::chrono::milliseconds kLastPatience{200};
constexpr std::chrono::milliseconds kLook{2};

/// Never destroyed: its destructor would join a thread that may wait for a reader for ever.
std::shared_ptr<spdlog::details::thread_pool>& pool() {
  static auto* const lines = new std::shared_ptr<spdlog::details::thread_pool>(
      std::make_shared<spdlog::details::thread_pool>(kMostLines, 1));
  return *lines;
}

}  // namespace

void log_to_stderr() {
  auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
  spdlog::set_default_logger(std::make_shared<spdlog::async_logger>(
      "hapticd", std::move(sink), pool(), spdlog::async_overflow_policy::overrun_oldest));
  spdlog::set_pattern("%H:%M:%S.%e %^%l%$ %v");
}

void finish_log() {
  const std::size_t gave_way = pool()->overrun_counter();
  if (gave_way > 0) spdlog::warn("{} lines of this log were lost: nobody read it", gave_way);
  // Behind everything else in the queue: when it has left, the lines before it are written.
  spdlog::default_logger()->flush();
  const auto give_up = std::chrono::steady_clock::now() + kLastPatience;
  while (pool()->queue_size() > 0 && std::chrono::steady_clock::now() < give_up) {
    std::this_thread::sleep_for(kLook);
  }
}

}  // namespace haptic::server
