#include "tests/report/bits/stored_hashes.hpp"

#include <gnu/libc-version.h>

#include <Eigen/Core>
#include <algorithm>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "haptic/core/error.hpp"

namespace haptic::report {
namespace {

constexpr const char* kBuiltBy = "built by: ";
constexpr const char* kFields = "fields: ";

std::string hex(std::uint16_t value) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  for (int shift = 12; shift >= 0; shift -= 4) text += kDigits[(value >> shift) & 0xFU];
  return text;
}

std::uint16_t from_hex(const std::string& text) {
  std::size_t used = 0;
  const unsigned long value = std::stoul(text, &used, 16);
  if (used != 4 || text.size() != 4) throw std::invalid_argument(text);
  return static_cast<std::uint16_t>(value);
}

/// Text behind `key` at the beginning of a line; nothing: it does not begin with it.
std::optional<std::string> after(const std::string& line, const std::string& key) {
  if (line.rfind(key, 0) != 0) return std::nullopt;
  return line.substr(key.size());
}

/// Hashes that stand one behind the other.
std::vector<std::uint16_t> hashes_of(const std::string& text) {
  std::vector<std::uint16_t> hashes;
  for (std::size_t i = 0; i < text.size(); i += 4) hashes.push_back(from_hex(text.substr(i, 4)));
  return hashes;
}

/// "finger_constant/finger 1", the hashes of the blocks, those of the fields.
void read_run(const std::string& line, const std::vector<std::string>& fields, StoredHashes& to) {
  std::istringstream in(line);
  RunName name;
  std::string blocks, of_fields;
  if (!(in >> name.first >> name.second >> blocks >> of_fields)) throw std::invalid_argument(line);
  StoredRun& run = to.runs[name];
  run.blocks = hashes_of(blocks);
  const std::vector<std::uint16_t> hashes = hashes_of(of_fields);
  if (hashes.size() != fields.size()) throw std::invalid_argument(line);
  for (std::size_t i = 0; i < fields.size(); ++i) run.fields[fields[i]] = hashes[i];
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
  for (const std::uint64_t block : hashes.blocks()) {
    run.blocks.push_back(static_cast<std::uint16_t>(block));
  }
  for (std::size_t i = 0; i < kept_fields().size(); ++i) {
    run.fields[kept_fields()[i].name] = static_cast<std::uint16_t>(hashes.field(i));
  }
  return run;
}

StoredHashes read_hashes(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw core::SceneError(file.string() + ": cannot be read");
  StoredHashes hashes;
  std::vector<std::string> fields;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (line.empty() || line.front() == '#') continue;
    if (const auto text = after(line, kBuiltBy)) {
      hashes.built_by = *text;
    } else if (const auto names = after(line, kFields)) {
      fields = names_of(*names);
    } else if (const auto exception = after(line, "except ")) {
      const std::size_t colon = exception->find(": ");
      hashes.exceptions[exception->substr(0, colon)] =
          colon == std::string::npos ? "" : exception->substr(colon + 2);
    } else {
      try {
        read_run(line, fields, hashes);
      } catch (const std::logic_error&) {
        throw core::SceneError(file.string() + ":" + std::to_string(number) +
                               ": must be device, seed, the hashes of the blocks and one per "
                               "field, of four hexadecimal digits each");
      }
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
    text += name.first + " " + std::to_string(name.second);
    text += " ";
    for (const std::uint16_t block : run.blocks) text += hex(block);
    text += " ";
    for (const KeptField& field : kept_fields()) text += hex(run.fields.at(field.name));
    text += "\n";
  }
  return text;
}

std::string difference(const StoredRun& now, const StoredRun& then, bool whole,
                       const std::map<std::string, std::string>& exceptions) {
  std::string text;
  const std::size_t blocks = std::min(now.blocks.size(), then.blocks.size());
  for (std::size_t i = 0; i < blocks && text.empty(); ++i) {
    if (now.blocks[i] == then.blocks[i]) continue;
    const std::size_t first = i * RunHashes::kBlock + 1;
    text = "the force differs first in ticks " + std::to_string(first) + " to " +
           std::to_string(first + RunHashes::kBlock - 1);
  }
  if (!whole) return text;
  std::string fields;
  for (const KeptField& field : kept_fields()) {
    const auto stored = then.fields.find(field.name);
    if (stored == then.fields.end() || exceptions.count(field.name) > 0) continue;
    if (now.fields.at(field.name) != stored->second) fields += std::string(" ") + field.name;
  }
  if (fields.empty()) return text;
  return (text.empty() ? "the force is the same" : text) + "; fields that differ:" + fields;
}

}  // namespace haptic::report
