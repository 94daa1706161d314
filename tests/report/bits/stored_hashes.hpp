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

/// One run, of each hash the 16 bits that are stored.
struct StoredRun {
  std::vector<std::uint16_t> blocks{};
  std::map<std::string, std::uint16_t> fields{};  ///< by name
};
[[nodiscard]] StoredRun shortened(const RunHashes& hashes);

struct StoredHashes {
  std::string built_by{};
  std::map<RunName, StoredRun> runs{};
  /// Why a device or a field (by its name) is not what it was: it is not compared.
  std::map<std::string, std::string> exceptions{};
};

/// Throws core::Error, which names the line.
[[nodiscard]] StoredHashes read_hashes(const std::filesystem::path& file);
/// The file's text. The remarks and exceptions at its beginning are those of `file`, if it is
/// there.
[[nodiscard]] std::string written(const StoredHashes& hashes, const std::filesystem::path& file);

/// Empty if `now` agrees with `then` as far as it goes; else a sentence: the block of ticks in
/// which the force first differs, and the fields that do. `whole`: both have the same number of
/// ticks, so that fields can be compared.
[[nodiscard]] std::string difference(const StoredRun& now, const StoredRun& then, bool whole,
                                     const std::map<std::string, std::string>& exceptions);

}  // namespace haptic::report
