#pragma once
/// Files that hapticd was told to read. A pipe in a file's place is refused and not waited for, a
/// device is not opened for what that may do, and no file fills the memory.

#include <cstdint>
#include <filesystem>
#include <string>

namespace haptic::hw {

/// A descriptor, for reading, of a plain file of at most `most` bytes; the caller's to close.
/// Below 0: `why` says what the file is or has instead.
[[nodiscard]] int open_plain_file(const std::filesystem::path& file, std::uintmax_t most,
                                  std::string& why);

/// Its content, without a byte order mark. Empty and `why` is set: as open_plain_file(), or UTF-16.
[[nodiscard]] std::string read_plain_file(const std::filesystem::path& file, std::uintmax_t most,
                                          std::string& why);

}  // namespace haptic::hw
