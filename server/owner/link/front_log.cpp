#include "server/owner/link/front_log.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <utility>

namespace haptic::server {
namespace {

using Level = spdlog::level::level_enum;

/// Takes "<N>" off, the priority by which a front begins its lines (log.hpp).
Level take_level(std::string_view& line) {
  if (line.size() < 3 || line[0] != '<' || line[2] != '>') return Level::warn;
  const char priority = line[1];
  line.remove_prefix(3);
  if (priority <= '2') return Level::critical;
  if (priority == '3') return Level::err;
  if (priority == '6') return Level::info;
  return priority == '7' ? Level::debug : Level::warn;
}

}  // namespace

FrontLog::FrontLog(Descriptor socket) : socket_(std::move(socket)) {}

FrontLog::~FrontLog() {
  say(rest_);
  close_aside(std::move(socket_));
}

bool FrontLog::copy(core::TimePoint now) {
  const std::chrono::duration<double> since = now - std::exchange(filled_, now);
  allowed_ = std::min(kAtOnce, allowed_ + std::min(since.count(), 60.0) * kBytesPerSecond);
  while (socket_ && allowed_ > 0.0) {
    const Next next = look_at_next(socket_.get());
    if (next.what != Received::kMessage) {
      if (next.what != Received::kNothing) close_aside(std::move(socket_));
      return next.what != Received::kBurdened;
    }
    std::array<char, 4096> bytes{};
    const auto got = take_bytes(socket_.get(), std::as_writable_bytes(std::span(bytes)));
    add({bytes.data(), static_cast<std::size_t>(std::max<std::ptrdiff_t>(got, 0))});
  }
  return true;
}

void FrontLog::add(std::string_view bytes) {
  allowed_ -= static_cast<double>(bytes.size() + kPerLine);
  for (const char c : bytes) {
    if (c != '\n') rest_ += c;
    if (c != '\n' && rest_.size() < kLongestLine) continue;
    say(rest_);
    rest_.clear();
    allowed_ -= kPerLine;
  }
}

void FrontLog::say(std::string_view line) {
  const Level level = take_level(line);
  if (!line.empty()) spdlog::log(level, "front: {}", line);
}

}  // namespace haptic::server
