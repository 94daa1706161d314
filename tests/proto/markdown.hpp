#pragma once
/// Reads the tables of a markdown document.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace haptic::test {

/// Throws std::runtime_error where the file cannot be read.
[[nodiscard]] std::string read_text(const std::filesystem::path& file);
/// The rows below the header whose first cell is `first_header`, cells without surrounding blanks.
/// Throws std::runtime_error unless there is exactly one such table.
[[nodiscard]] std::vector<std::vector<std::string>> markdown_table(const std::string& text,
                                                                   const std::string& first_header);
/// "`X`" -> "X"; anything else as it is.
[[nodiscard]] std::string unquoted(const std::string& cell);

}  // namespace haptic::test
