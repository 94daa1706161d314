#pragma once
/// The hashes of runs as a small text file, and what a comparison with them says.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/report/bits/kept_fields.hpp"

namespace haptic::report {

/// Other things that decide the bits: compiler, C library, Eigen, processor, options.
[[nodiscard]] std::string built_by();

/// A device of a scene ("finger_constant/finger"), and a seed.
using RunName = std::pair<std::string, int>;

/// One run, of each hash the 16 bits that are stored: four hexadecimal digits each.
struct StoredRun {
  std::string blocks{}, fields{};
};
[[nodiscard]] StoredRun shortened(const RunHashes& hashes);

struct StoredHashes {
  std::string built_by{};
  std::vector<std::string> fields{};  ///< names, in the order of a run's
  std::map<RunName, StoredRun> runs{};
  /// Why a device or a field (by its name) is not what it was: it is not compared.
  std::map<std::string, std::string> exceptions{};
};

/// Throws core::Error, which names the line.
[[nodiscard]] StoredHashes read_hashes(const std::filesystem::path& file);
/// The file's text. The remarks and exceptions at its beginning are those of `file`, if it is
/// there.
[[nodiscard]] std::string written(const StoredHashes& hashes, const std::filesystem::path& file);

/// Empty if `now` agrees with the run `then` of `stored` as far as it goes; else a sentence: the
/// block of ticks in which the force first differs, and the fields that do, if both have the same
/// number of ticks.
[[nodiscard]] std::string difference(const StoredRun& now, const StoredRun& then,
                                     const StoredHashes& stored);

}  // namespace haptic::report
