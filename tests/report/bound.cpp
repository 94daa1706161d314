/// haptic-report bound: is the error bound true, and how tight (core/METHOD.md#error-bound)?
#include <cstdio>

#include "haptic/core/error.hpp"
#include "tests/report/bound_study.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/support/percentile.hpp"

namespace haptic::report {
namespace {

struct Options {
  int runs{10000};
  std::string kind{};
  std::uint64_t first{0};
};

void print(std::string_view kind, const BoundRuns& all) {
  const auto share = [](const std::vector<double>& values, double p) {
    return test::percentile(values, p);
  };
  row(kind, all.runs, all.broken_runs, all.ticks,
      100.0 * static_cast<double>(all.known) / static_cast<double>(std::max(1L, all.ticks)),
      all.broken, all.worst, all.worst_run, share(all.errors, 0.5), share(all.bounds, 0.5),
      share(all.errors, 0.95), share(all.bounds, 0.95));
  std::fflush(stdout);
}

void print_all(const Options& options) {
  row("kind", "runs", "broken_runs", "contact_ticks", "known_pct", "broken_ticks", "worst_n",
      "worst_run", "error_50_n", "bound_50_n", "error_95_n", "bound_95_n");
  const int each = std::max(1, options.runs / static_cast<int>(kBoundKinds.size()));
  BoundRuns still;
  long broken = 0;
  for (const BoundKind kind : kBoundKinds) {
    if (!chosen(options.kind, name(kind))) continue;
    BoundRuns all;
    for (int i = 0; i < each; ++i) {
      all.add(bound_run(kind, options.first + static_cast<std::uint64_t>(i)));
    }
    print(name(kind), all);
    broken += all.broken_runs;
    if (!moves(kind)) still.add(all);
  }
  print("still", still);
  if (broken > 0) {
    throw core::SceneError("bound: " + std::to_string(broken) + " runs break their bound");
  }
}

}  // namespace

void add_bound(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "bound", "Whether the error bound holds for random bodies behind a network");
  command->footer(
      "Virtual time; the run's number draws all of it. Exit status 2 if a bound is broken. error_, "
      "bound_: median and 95 % of the ticks in contact that have a bound. Last row: all kinds "
      "whose round bodies do not move.");
  auto o = std::make_shared<Options>();
  command->add_option("--runs", o->runs, "of all kinds together (10000)")
      ->check(CLI::Range(1, 1000000));
  command->add_option("--kind", o->kind, "this one alone");
  command->add_option("--first", o->first, "number of the first run (0)");
  command->callback([o] { print_all(*o); });
}

}  // namespace haptic::report
