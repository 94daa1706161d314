/// haptic-bare-loop SECONDS: a loop of 1 kHz that does nothing, with hapticd's wishes of real time:
/// what this machine itself does to a loop. A line a second: deadlines missed, 99th percentile of
/// the lateness in us.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "server/owner/loop/realtime.hpp"

namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr std::int64_t kPeriodNs = 1'000'000;

std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kSecondNs + now.tv_nsec;
}

void sleep_until(std::int64_t deadline_ns) {
  const timespec at{static_cast<std::time_t>(deadline_ns / kSecondNs),
                    static_cast<long>(deadline_ns % kSecondNs)};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
}

void print(std::vector<double>& late_us, std::int64_t missed) {
  std::sort(late_us.begin(), late_us.end());
  const std::size_t i = late_us.size() * 99 / 100;
  std::printf("%lld,%.1f\n", static_cast<long long>(missed),
              late_us.empty() ? 0.0 : late_us[std::min(i, late_us.size() - 1)]);
  std::fflush(stdout);
  late_us.clear();
}

}  // namespace

int main(int argc, char** argv) {
  const long seconds = argc > 1 ? std::strtol(argv[1], nullptr, 10) : 0;
  if (seconds <= 0) {
    std::fprintf(stderr, "usage: haptic-bare-loop SECONDS\n");
    return 2;
  }
  static_cast<void>(haptic::server::apply_realtime({}, haptic::server::real_host()));
  std::vector<double> late_us;
  late_us.reserve(kSecondNs / kPeriodNs);
  std::int64_t deadline = now_ns();
  std::int64_t told = deadline;
  std::int64_t missed = 0;
  for (long second = 0; second < seconds;) {
    deadline += kPeriodNs;
    sleep_until(deadline);
    const std::int64_t now = now_ns();
    late_us.push_back(static_cast<double>(now - deadline) * 1e-3);
    const std::int64_t skipped = (now - deadline) / kPeriodNs;  // deadlines that passed meanwhile
    missed += skipped;
    deadline += skipped * kPeriodNs;
    if (deadline - told < kSecondNs) continue;
    print(late_us, missed);
    told += kSecondNs;
    missed = 0;
    ++second;
  }
  return 0;
}
