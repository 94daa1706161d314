#include "server/telemetry/stderr_log.hpp"

#include <poll.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <climits>
#include <memory>
#include <mutex>
#include <string>

namespace haptic::server {
namespace {

class StderrSink final : public spdlog::sinks::base_sink<std::mutex> {
 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    if (!takes_a_line()) {
      ++lost_;
      return;
    }
    if (lost_ > 0) {
      write(std::to_string(lost_) + " lines of this log were lost: nobody read it\n");
      lost_ = 0;
      if (!takes_a_line()) {
        ++lost_;
        return;
      }
    }
    spdlog::memory_buf_t line;
    formatter_->format(message, line);
    write({line.data(), line.size()});
  }
  void flush_() override {}

 private:
  /// A pipe, a socket or a terminal that polls as writable takes PIPE_BUF bytes without waiting, a
  /// file always does.
  static bool takes_a_line() {
    pollfd standard_error{STDERR_FILENO, POLLOUT, 0};
    return poll(&standard_error, 1, 0) == 1 && (standard_error.revents & POLLOUT) != 0;
  }
  static void write(std::string line) {
    if (line.size() > PIPE_BUF) {
      line.resize(PIPE_BUF);
      line.back() = '\n';
    }
    // A reader that went away is no reason to stop: SIGPIPE is ignored, and so is this.
    static_cast<void>(::write(STDERR_FILENO, line.data(), line.size()) < 0);
  }

  std::uint64_t lost_{0};
};

}  // namespace

void log_to_stderr() {
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("hapticd", std::make_shared<StderrSink>()));
  spdlog::set_pattern("%H:%M:%S.%e %l %v");
}

}  // namespace haptic::server
