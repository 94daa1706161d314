/// haptic-bare-loop SECONDS: a loop of 1 kHz that does nothing, with hapticd's wishes of real time:
/// what this machine itself does to a loop. A line a second: deadlines missed, 99th percentile of
/// the lateness in us.
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "tests/bench/bare_loop.hpp"
#include "tests/support/percentile.hpp"

int main(int argc, char** argv) {
  using namespace haptic;
  constexpr std::int64_t kDeadlines = bench::kSecondNs / bench::kTickNs;  // of a line
  long seconds = argc > 1 ? std::strtol(argv[1], nullptr, 10) : 0;
  if (seconds <= 0) {
    std::fprintf(stderr, "usage: haptic-bare-loop SECONDS\n");
    return 2;
  }
  std::vector<double> late_us;
  late_us.reserve(static_cast<std::size_t>(kDeadlines));
  std::int64_t deadlines = 0, missed = 0;
  bench::bare_loop([&](double late, std::int64_t passed) {
    late_us.push_back(late);
    missed += passed;
    deadlines += 1 + passed;
    if (deadlines < kDeadlines) return true;
    std::printf("%lld,%.1f\n", static_cast<long long>(missed), test::percentile(late_us, 0.99));
    std::fflush(stdout);
    late_us.clear();
    missed = 0;
    deadlines -= kDeadlines;
    return --seconds > 0;
  });
  return 0;
}
