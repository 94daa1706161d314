#include "tests/proto/markdown.hpp"

#include <fstream>
#include <sstream>
#include <stdexcept>

namespace haptic::test {
namespace {

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(' ');
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line.substr(1));
  for (std::string cell; std::getline(stream, cell, '|');) cells.push_back(trimmed(cell));
  return cells;
}

}  // namespace

std::string read_text(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error("cannot read " + file.string());
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::vector<std::vector<std::string>> markdown_table(const std::string& text,
                                                     const std::string& first_header) {
  std::vector<std::vector<std::string>> rows;
  int tables = 0;
  bool above_is_text = true;
  bool inside = false;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    const bool is_row = !line.empty() && line.front() == '|';
    if (is_row && above_is_text) {
      inside = cells_of(line).front() == first_header;
      tables += inside ? 1 : 0;
    } else if (is_row && inside && line.rfind("|---", 0) != 0) {
      rows.push_back(cells_of(line));
    }
    above_is_text = !is_row;
  }
  if (tables != 1 || rows.empty()) {
    throw std::runtime_error(std::to_string(tables) + " tables begin with '" + first_header + "'");
  }
  return rows;
}

std::string unquoted(const std::string& cell) {
  const bool quoted = cell.size() > 2 && cell.front() == '`' && cell.back() == '`';
  return quoted ? cell.substr(1, cell.size() - 2) : cell;
}

}  // namespace haptic::test
