#include "server/rt/loop.hpp"

#include <csignal>
#include <ctime>

#include "server/rpc/steady_now.hpp"
#include "server/rt/deadline_grid.hpp"

namespace haptic::server {

namespace {

void sleep_until(core::TimePoint deadline) noexcept {
  const auto ns = deadline.time_since_epoch().count();
  timespec at{};
  at.tv_sec = static_cast<std::time_t>(ns / 1'000'000'000);
  at.tv_nsec = static_cast<long>(ns % 1'000'000'000);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) == EINTR) {
  }
}

}  // namespace

Loop::Loop(core::Duration period) : period_(period) {}

Loop::~Loop() {
  if (!thread_.joinable()) return;
  if (!told_) {
    go_.set_value(false);
    thread_.join();
  } else {
    finish(core::Duration::zero());
  }
}

RealtimeFacts Loop::prepare(const RealtimeRequest& request) {
  std::promise<RealtimeFacts> granted;
  std::future<RealtimeFacts> answer = granted.get_future();
  std::future<bool> go = go_.get_future();
  thread_ = std::thread([this, request, granted = std::move(granted),
                         go = std::move(go)]() mutable {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, nullptr);
    pthread_setname_np(pthread_self(), "haptic-rt");
    try {
      granted.set_value(apply_realtime(request));
    } catch (...) {
      granted.set_exception(std::current_exception());
      return;
    }
    if (go.get()) main();
  });
  try {
    return answer.get();
  } catch (...) {
    thread_.join();
    throw;
  }
}

void Loop::run(std::vector<DeviceUnit*> units, Telemetry& telemetry) {
  units_ = std::move(units);
  telemetry_ = &telemetry;
  told_ = true;
  go_.set_value(true);
}

bool Loop::all_closing() const noexcept {
  for (const DeviceUnit* unit : units_) {
    if (unit->state() != core::DeviceState::kClosing) return false;
  }
  return true;
}

void Loop::main() {
  DeadlineGrid grid(steady_now() + period_, period_);
  while (true) {
    sleep_until(grid.deadline());
    const core::TimePoint now = steady_now();
    const core::LoopReport report = grid.woke(now);
    for (DeviceUnit* unit : units_) unit->tick(now, period_, report);
    telemetry_->wake();

    lateness_.add(report.lateness, now);
    work_.add(steady_now() - now, now);
    ticks_.fetch_add(1, std::memory_order_relaxed);
    skipped_.fetch_add(report.skipped, std::memory_order_relaxed);
    if (finishing_.load(std::memory_order_acquire) &&
        (all_closing() || now >= give_up_.load(std::memory_order_relaxed))) {
      return;
    }
  }
}

void Loop::finish(core::Duration longest) {
  if (!thread_.joinable()) return;
  give_up_.store(steady_now() + longest, std::memory_order_relaxed);
  finishing_.store(true, std::memory_order_release);
  thread_.join();
}

LoopFacts Loop::facts() const {
  LoopFacts out;
  const Percentiles late = lateness_.read();
  const Percentiles work = work_.read();
  out.ticks = ticks_.load(std::memory_order_relaxed);
  out.skipped = skipped_.load(std::memory_order_relaxed);
  out.lateness_p50_us = late.p50_us;
  out.lateness_p99_us = late.p99_us;
  out.lateness_max_us = late.max_us;
  out.tick_p50_us = work.p50_us;
  out.tick_p99_us = work.p99_us;
  return out;
}

}  // namespace haptic::server
