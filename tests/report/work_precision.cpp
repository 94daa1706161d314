/// haptic-report work-precision: what a way to q* costs, and how exact it is
/// (core/METHOD.md#work-and-precision and core/METHOD.md#larger-devices).
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>

#include "haptic/core/model/finger_exoskeleton.hpp"
#include "tests/bench/paired.hpp"
#include "tests/report/command.hpp"
#include "tests/report/csv.hpp"
#include "tests/report/work_precision/method.hpp"
#include "tests/report/work_precision/part.hpp"

namespace haptic::report {
namespace {

struct Options {
  std::string map{"all"};
  int blocks{24};
};

struct Errors {
  double max{0.0}, rms{0.0};
};

/// Of S q*, over every frame; NaN counts as the worst there is.
Errors errors_of(Method& method, const Study& study) {
  const core::DofLayout& layout = study.kinematics->layout();
  Errors errors;
  double squares = 0.0;
  method.begin(study.q_star.front());
  for (std::size_t k = 0; k < study.q.size(); ++k) {
    const core::VecQ& q_star = method.solve(study.q[k], study.x[k]);
    const double error = (layout.select(q_star) - layout.select(study.q_star[k])).norm();
    if (!(error <= errors.max)) errors.max = error;
    squares += error * error;
  }
  errors.rms = std::sqrt(squares / static_cast<double>(study.q.size()));
  return errors;
}

/// ns per call over one run of many.
bench::Block block_of(const std::function<void()>& run, int calls) {
  return [run, calls] {
    return bench::ns_per_call(8,
                              [&](int times) {  // paired.hpp sheds what the machine disturbs
                                for (int i = 0; i < times; ++i) run();
                              }) /
           calls;
  };
}

bench::Block block_of(Method& method, const Study& study) {
  return block_of(
      [&method, &study] {
        method.begin(study.q_star.front());
        for (std::size_t k = 0; k < study.q.size(); ++k) {
          static_cast<void>(method.solve(study.q[k], study.x[k]));
        }
      },
      static_cast<int>(study.q.size()));
}

void print(const std::string& map, const std::string& setting, const std::string& method,
           const Errors& errors, const std::string& unit, const bench::Row& timed) {
  row(map, setting, method, timed.ours, errors.max, errors.rms, unit, timed.against,
      timed.ratio.median, timed.ratio.lower, timed.ratio.upper, timed.a_a.lower, timed.a_a.upper);
  std::fflush(stdout);
}

void print_study(const Study& study, const std::string& setting, int blocks) {
  Methods methods = own_methods(*study.kinematics);
  for (const auto& more : {&tiny_solver_methods, &cminpack_methods}) {
    Methods peers = more(*study.kinematics);
    for (auto& peer : peers) methods.push_back(std::move(peer));
  }
  const Methods baseline = own_methods(*study.kinematics);
  const bench::Block eq8 = block_of(*baseline.front(), study);
  for (const auto& method : methods) {
    const Errors errors = errors_of(*method, study);
    const bench::Row timed =
        bench::compare(method->name(), "eq8", "ns", block_of(*method, study), eq8, 0.0, blocks);
    print(study.map, setting, method->name(), errors, study.error_unit, timed);
  }
}

void print_parts(int blocks) {
  for (const auto& make : {&plane_figures, &envelope_figures, &tank_figures, &rotation_figures}) {
    for (const PartFigure& part : make()) {
      const bench::Row timed =
          bench::compare(part.method, part.against, "ns", block_of(part.ours, part.calls),
                         block_of(part.theirs, part.calls), 0.0, blocks);
      print(part.map, part.setting, part.method, {part.error_max, part.error_rms}, part.error_unit,
            timed);
    }
  }
}

void print_all(const Options& options) {
  const auto finger = core::make_finger_exoskeleton({});
  if (tiny_solver_methods(*finger).empty() || cminpack_methods(*finger).empty()) {
    std::fprintf(
        stderr,
        "work-precision: built without libceres-dev or libcminpack-dev; their rows are left "
        "out (docker/install-deps.sh report)\n");
  }
  row("map", "setting", "method", "ns", "error_max", "error_rms", "error_unit", "against", "ratio",
      "lower", "upper", "aa_lower", "aa_upper");
  for (const auto& make : {&finger_study, &hand_study, &tracked_hand_study, &chain_study}) {
    for (const double rate : {1000.0, 60.0}) {
      const Study study = make(rate);
      if (options.map != "all" && options.map != study.map) break;
      print_study(study, cell(static_cast<int>(rate)) + " Hz", options.blocks);
    }
  }
  if (options.map == "all" || options.map == "parts") print_parts(options.blocks);
}

}  // namespace

void add_work_precision(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("work-precision", "ns and error of q*: Eq. (8), iterations, peers");
  command->footer(
      "error: of S q* against a reference converged to 1e-12, over one second of frames at 1000 "
      "and "
      "60 Hz, in the unit given; ns per solve, f and J included. ratio: against the method named, "
      "in "
      "alternating blocks of one run with its bootstrap 95 % interval and an A/A interval. parts: "
      "planes, monotone envelope and the chord of rotations, each against a plain answer.");
  auto options = std::make_shared<Options>();
  command->add_option("--map", options->map, "one alone (all)")
      ->check(CLI::IsMember({"all", "finger", "hand", "tracked_hand", "chain", "parts"}));
  command
      ->add_option("--blocks", options->blocks,
                   "alternations per figure (24; at least 20 where it is quoted)")
      ->check(CLI::Range(1, 1000));
  command->callback([options] { print_all(*options); });
}

}  // namespace haptic::report
