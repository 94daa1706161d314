#include "vectors.hpp"

#include <fstream>
#include <sstream>
#include <stdexcept>

#include "tests/proto/wire/hex.hpp"

namespace haptic::test {
namespace {

Vector parse_head(const std::string& line) {
  std::istringstream words(line);
  std::string type, seq_word;
  Vector vector;
  if (!(words >> vector.name >> type >> seq_word >> vector.seq) || seq_word != "seq") {
    throw std::runtime_error("not a vector: " + line);
  }
  vector.type = static_cast<std::uint8_t>(std::stoul(type, nullptr, 16));
  return vector;
}

std::vector<Vector> load() {
  std::ifstream file(HAPTIC_SOURCE_DIR "/hw/README.md");
  std::string line;
  while (std::getline(file, line) && line != "```vectors") {
  }
  std::vector<Vector> found;
  std::vector<std::uint8_t>* part = nullptr;
  while (std::getline(file, line) && line != "```") {
    if (line == "  payload") {
      part = &found.back().payload;
    } else if (line == "  wire") {
      part = &found.back().wire;
    } else if (line.starts_with("    ")) {
      const std::vector<std::uint8_t> bytes = from_hex(line);
      part->insert(part->end(), bytes.begin(), bytes.end());
    } else {
      found.push_back(parse_head(line));
    }
  }
  if (found.empty()) throw std::runtime_error("hw/README.md holds no vectors");
  return found;
}

}  // namespace

const std::vector<Vector>& vectors() {
  static const std::vector<Vector> all = load();
  return all;
}

const Vector& vector(const std::string& name) {
  for (const Vector& vector : vectors()) {
    if (vector.name == name) return vector;
  }
  throw std::runtime_error("hw/README.md holds no vector " + name);
}

}  // namespace haptic::test
