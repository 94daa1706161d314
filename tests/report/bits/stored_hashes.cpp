#include "tests/report/bits/stored_hashes.hpp"

#include <gnu/libc-version.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <optional>
#include <sstream>

#include "haptic/core/error.hpp"

namespace haptic::report {
namespace {

constexpr const char* kBuiltBy = "built by: ";
constexpr const char* kFields = "fields: ";

constexpr std::size_t kDigits = 4;

std::string hex(std::uint64_t hash) {
  char text[kDigits + 1];
  std::snprintf(text, sizeof text, "%04x", static_cast<unsigned>(hash & 0xFFFFU));
  return text;
}

/// Text behind `key` at the beginning of a line; nothing: it does not begin with it.
std::optional<std::string> after(const std::string& line, const std::string& key) {
  if (line.rfind(key, 0) != 0) return std::nullopt;
  return line.substr(key.size());
}

/// "finger_constant/finger 1", the hashes of the blocks, those of the fields. Returns false if the
/// line has not all of that.
bool read_run(const std::string& line, StoredHashes& to) {
  std::istringstream in(line);
  RunName name;
  StoredRun run;
  if (!(in >> name.first >> name.second >> run.blocks >> run.fields)) return false;
  to.runs[name] = run;
  return (run.blocks + run.fields).find_first_not_of("0123456789abcdef") == std::string::npos &&
         run.blocks.size() % kDigits == 0 && run.fields.size() == kDigits * to.fields.size();
}

std::vector<std::string> names_of(const std::string& list) {
  std::istringstream in(list);
  std::vector<std::string> names;
  for (std::string name; std::getline(in, name, ',');) names.push_back(name);
  return names;
}

}  // namespace

std::string built_by() {
  std::string text = "GCC " __VERSION__ ", glibc ";
  text += gnu_get_libc_version();
  text += ", Eigen " + std::to_string(EIGEN_WORLD_VERSION) + "." +
          std::to_string(EIGEN_MAJOR_VERSION) + "." + std::to_string(EIGEN_MINOR_VERSION);
#if defined(__x86_64__)
  // glibc chooses another sine where the processor multiplies and adds in one step.
  text += __builtin_cpu_supports("fma") != 0 ? ", x86-64 with FMA" : ", x86-64 without FMA";
#else
  text += ", another processor";
#endif
#if defined(NDEBUG) && defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
  text += ", preset release";
#else
  text += ", another preset";
#endif
  return text;
}

StoredRun shortened(const RunHashes& hashes) {
  StoredRun run;
  for (const std::uint64_t block : hashes.blocks()) run.blocks += hex(block);
  for (std::size_t i = 0; i < kept_fields().size(); ++i) run.fields += hex(hashes.field(i));
  return run;
}

StoredHashes read_hashes(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw core::SceneError(file.string() + ": cannot be read");
  StoredHashes hashes;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.empty() || line.front() == '#') continue;
    if (const auto text = after(line, kBuiltBy)) {
      hashes.built_by = *text;
    } else if (const auto names = after(line, kFields)) {
      hashes.fields = names_of(*names);
    } else if (const auto exception = after(line, "except ")) {
      const std::size_t colon = exception->find(": ");
      hashes.exceptions[exception->substr(0, colon)] =
          colon == std::string::npos ? "" : exception->substr(colon + 2);
    } else if (!read_run(line, hashes)) {
      throw core::SceneError(file.string() + ":" + std::to_string(number) +
                             ": must be device, seed, the hashes of the blocks and one per field, "
                             "of four hexadecimal digits each");
    }
  }
  return hashes;
}

std::string written(const StoredHashes& hashes, const std::filesystem::path& file) {
  std::string text;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line) && !after(line, kBuiltBy);) text += line + "\n";
  text += kBuiltBy + hashes.built_by + "\n" + kFields;
  for (const KeptField& field : kept_fields()) text += std::string(field.name) + ",";
  text.back() = '\n';
  for (const auto& [name, run] : hashes.runs) {
    text +=
        name.first + " " + std::to_string(name.second) + " " + run.blocks + " " + run.fields + "\n";
  }
  return text;
}

std::string difference(const StoredRun& now, const StoredRun& then, const StoredHashes& stored) {
  const auto [here, there] =
      std::mismatch(now.blocks.begin(), now.blocks.end(), then.blocks.begin(), then.blocks.end());
  std::string text;
  if (here != now.blocks.end() && there != then.blocks.end()) {
    const auto block = static_cast<std::size_t>(here - now.blocks.begin()) / kDigits;
    const std::size_t first = block * RunHashes::kBlock + 1;
    text = "the force differs first in ticks " + std::to_string(first) + " to " +
           std::to_string(first + RunHashes::kBlock - 1);
  }
  if (now.blocks.size() != then.blocks.size()) return text;
  std::string fields;
  for (std::size_t i = 0; i < kept_fields().size(); ++i) {
    const char* const name = kept_fields()[i].name;
    const auto at = std::find(stored.fields.begin(), stored.fields.end(), name);
    if (at == stored.fields.end() || stored.exceptions.count(name) > 0) continue;
    const auto k = static_cast<std::size_t>(at - stored.fields.begin());
    if (now.fields.compare(kDigits * i, kDigits, then.fields, kDigits * k, kDigits) != 0) {
      fields += std::string(" ") + name;
    }
  }
  if (fields.empty()) return text;
  return (text.empty() ? "the force is the same" : text) + "; fields that differ:" + fields;
}

}  // namespace haptic::report
