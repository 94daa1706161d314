/// haptic-bits: runs every shipped scene in virtual time and compares what the loop computes, to
/// the bit, with stored hashes (tests/report/run.sh bits). Exit status: 0 the same, 1 not, 2 an
/// error, 77 the hashes are those of another compiler or processor.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>

#include "haptic/core/error.hpp"
#include "server/owner/scene/shipped.hpp"
#include "tests/report/bits/scene_run.hpp"
#include "tests/report/bits/stored_hashes.hpp"

namespace haptic::report {
namespace {

constexpr int kNotComparable = 77;

struct Options {
  std::filesystem::path scenes{server::shipped_scenes_folder()};
  std::filesystem::path stored{};
  std::string only{};
  int seeds{3};
  int ticks{3000};
  int flip{0};
  bool write{false};
  bool trace{false};
};

/// Calls `observe` with the record of each tick.
template <typename Observe>
void run(const ShippedDevice& which, int seed, const Options& options, const Observe& observe) {
  SceneRun scene = make_run(which, static_cast<std::uint64_t>(seed));
  for (int tick = 1; tick <= options.ticks; ++tick) {
    if (tick == options.flip) scene.flip_a_bit();
    observe(scene.tick());
  }
}

StoredHashes run_all(const Options& options) {
  StoredHashes now;
  now.built_by = built_by();
  for (const ShippedDevice& which : shipped_devices(options.scenes)) {
    if (!options.only.empty() && which.name != options.only) continue;
    for (int seed = 1; seed <= options.seeds; ++seed) {
      RunHashes hashes;
      int engaged = 0, pushes = 0, faulty = 0;
      run(which, seed, options, [&](const core::TickRecord& record) {
        hashes.add(record);
        engaged += record.life.gain > 0.0 ? 1 : 0;
        pushes += record.effort.tau_elastic.cwiseAbs().sum() > 0.0 ? 1 : 0;
        faulty += record.faults().any() ? 1 : 0;
      });
      std::fprintf(stderr, "%s seed %d: %d ticks, gain above 0 in %d, force in %d, a fault in %d\n",
                   which.name.c_str(), seed, options.ticks, engaged, pushes, faulty);
      now.runs[{which.name, seed}] = shortened(hashes);
    }
  }
  return now;
}

/// Every field of every tick of one run, as "tick,field,words".
void trace(const Options& options) {
  for (const ShippedDevice& which : shipped_devices(options.scenes)) {
    if (which.name != options.only) continue;
    int tick = 0;
    Words words;
    run(which, options.seeds, options, [&](const core::TickRecord& record) {
      ++tick;
      for (const KeptField& field : kept_fields()) {
        words.clear();
        field.write(record, words);
        std::printf("%d,%s", tick, field.name);
        for (const std::uint64_t word : words) {
          std::printf(" %llx", static_cast<unsigned long long>(word));
        }
        std::printf("\n");
      }
    });
  }
}

/// The verdict on a run; empty: it has the stored bits.
std::string judged(const RunName& name, const StoredRun& run, const StoredHashes& then) {
  const auto stored = then.runs.find(name);
  if (stored == then.runs.end()) return "has no stored hash: run.sh bits --write stores it";
  return difference(run, stored->second, then);
}

int compare(const Options& options) {
  const StoredHashes then = read_hashes(options.stored);
  if (then.built_by != built_by()) {
    std::printf(
        "cannot compare: the bits depend on what computes them\n"
        "  stored: %s\n  here:   %s\n",
        then.built_by.c_str(), built_by().c_str());
    return kNotComparable;
  }
  for (const auto& [what, why] : then.exceptions) {
    std::printf("%s: not compared: %s\n", what.c_str(), why.c_str());
  }
  const StoredHashes now = run_all(options);
  int compared = 0, differ = 0;
  const auto tell = [&differ](const RunName& name, const char* what) {
    std::printf("%s seed %d: %s\n", name.first.c_str(), name.second, what);
    ++differ;
  };
  for (const auto& [name, run] : now.runs) {
    if (then.exceptions.count(name.first) > 0) continue;
    ++compared;
    const std::string what = judged(name, run, then);
    if (!what.empty()) tell(name, what.c_str());
  }
  for (const auto& [name, run] : then.runs) {
    const bool asked_for = options.only.empty() && name.second <= options.seeds;
    if (asked_for && now.runs.count(name) == 0) tell(name, "is stored, but no scene has it");
  }
  std::printf("%d runs of %d ticks compared, %d differ\n", compared, options.ticks, differ);
  return compared > 0 && differ == 0 ? 0 : 1;
}

int act(const Options& options) {
  if (options.trace) {
    trace(options);
    return 0;
  }
  if (!options.write) return compare(options);
  const std::string text = written(run_all(options), options.stored);
  std::ofstream(options.stored) << text;
  return 0;
}

}  // namespace
}  // namespace haptic::report

int main(int argc, char** argv) {
  haptic::report::Options options;
  CLI::App app{"Compares what every shipped scene computes, to the bit, with stored hashes"};
  app.add_option("--scenes", options.scenes, "folder of the scenes");
  app.add_option("--stored", options.stored, "file of the hashes");
  app.add_option("--only", options.only, "one device of one scene: finger_constant/finger");
  app.add_option("--seeds", options.seeds, "seeds 1 to this; with --trace this one");
  app.add_option("--ticks", options.ticks, "of each run");
  app.add_option("--flip", options.flip, "in this tick one bit of the device's reading is wrong");
  app.add_flag("--write", options.write, "stores the hashes instead of comparing them");
  app.add_flag("--trace", options.trace, "prints every field of every tick of --only instead");
  CLI11_PARSE(app, argc, argv);
  try {
    return haptic::report::act(options);
  } catch (const haptic::core::Error& error) {
    std::fprintf(stderr, "haptic-bits: %s\n", error.what());
    return 2;
  }
}
