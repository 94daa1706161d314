#include "hw/motion/motion_csv.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <string_view>

#include "haptic/core/error.hpp"
#include "hw/plain_file.hpp"

namespace haptic::hw {
namespace {

constexpr std::string_view kTime = "time_s";
/// Limits of a time stamp, and of the whole recording: in nanoseconds both then fit an int64.
constexpr double kLargestTime = 9e9;                  // s
constexpr std::uintmax_t kLargestFile = 256U << 20U;  // bytes
/// A row that stands for longer, on average, is hardly of a recording.
constexpr double kLongestRow = 0.5;  // s
/// No finger goes beyond: MCP and PIP flex by 1.75 and 1.83 rad (M. C. Hume et al., J. Hand Surg.
/// 15A:240-243, 1990).
constexpr double kLeastBend = -1.0, kMostBend = 2.2;  // rad

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n";
  const auto begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

/// Without the blanks and the quotes around it.
std::string_view plain(std::string_view field) {
  field = trimmed(field);
  const bool quoted = field.size() > 1 && field.front() == field.back() &&
                      (field.front() == '"' || field.front() == '\'');
  return quoted ? trimmed(field.substr(1, field.size() - 2)) : field;
}

std::vector<std::string_view> fields_of(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  for (;;) {
    const auto end = line.find(separator);
    fields.push_back(plain(line.substr(0, end)));
    if (end == std::string_view::npos) return fields;
    line.remove_prefix(end + 1);
  }
}

/// Names of the columns, and what stands between two of them.
struct Header {
  char separator{','};
  std::vector<std::string_view> names{};
};

Header header_of(std::string_view line) {
  if (constexpr std::string_view kMark = "\xEF\xBB\xBF"; line.starts_with(kMark)) {
    line.remove_prefix(kMark.size());
  }
  if (line.starts_with('#')) line.remove_prefix(1);  // as numpy.savetxt writes it
  Header header;
  for (const char other : {';', '\t'}) {
    if (line.find(header.separator) == std::string_view::npos) header.separator = other;
  }
  header.names = fields_of(line, header.separator);
  return header;
}

template <typename Names>
std::string joined(const Names& names) {
  std::string text;
  for (const auto& name : names) {
    if (!text.empty()) text += ", ";
    text += name;
  }
  return text;
}

/// The line being read, for messages.
struct Place {
  const std::filesystem::path& file;
  std::size_t line{0};

  [[noreturn]] void fail(const std::string& what) const {
    throw core::DeviceError(line == 0 ? file.string() + ": " + what
                                      : file.string() + ":" + std::to_string(line) + ": " + what);
  }
  [[noreturn]] void fail(std::string_view column, std::string_view value,
                         const std::string& expected) const {
    std::string part(value.substr(0, 60));
    std::replace(part.begin(), part.end(), '\0', '?');  // a message ends at a zero byte
    if (part.size() < value.size()) part += "...";
    fail("column " + std::string(column) + " = '" + part + "': " + expected);
  }
};

double number(const Place& place, std::string_view column, std::string_view text) {
  std::string_view digits = text;
  if (digits.size() > 1 && digits.front() == '+' && digits[1] != '-') digits.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc{} || end != digits.data() + digits.size() || !std::isfinite(value)) {
    place.fail(column, text,
               text.find(',') == std::string_view::npos
                   ? "must be a finite number"
                   : "must be a finite number with a decimal point, not a comma");
  }
  return value;
}

/// Which fields of a row are wanted: time first, then the columns of the chosen set.
struct Selection {
  std::size_t alternative{0};
  std::vector<std::size_t> field{};
  ColumnSet name{};
};

Selection select(const Place& place, const std::vector<std::string_view>& header,
                 const std::vector<ColumnSet>& alternatives) {
  std::string expected;
  for (std::size_t a = 0; a < alternatives.size(); ++a) {
    Selection selection{.alternative = a};
    selection.name.emplace_back(kTime);
    selection.name.insert(selection.name.end(), alternatives[a].begin(), alternatives[a].end());
    ColumnSet missing;
    for (const std::string& name : selection.name) {
      const auto at = std::find(header.begin(), header.end(), name);
      if (at == header.end()) {
        missing.push_back(name);
        continue;
      }
      if (std::find(at + 1, header.end(), name) != header.end()) {
        place.fail("column " + name + " stands twice in the header; once is allowed");
      }
      selection.field.push_back(static_cast<std::size_t>(at - header.begin()));
    }
    if (missing.empty()) return selection;
    expected +=
        (a == 0 ? "" : "; or ") + joined(selection.name) + " (missing: " + joined(missing) + ")";
  }
  place.fail("columns found: " + joined(header).substr(0, 1000) + "; expected " + expected +
             ", with commas, semicolons or tabs between them");
}

/// The values of a line, none of them without a column.
std::vector<std::string_view> values_of(const Place& place, std::string_view line,
                                        const Header& header) {
  std::vector<std::string_view> values = fields_of(line, header.separator);
  while (values.size() > header.names.size() && values.back().empty()) values.pop_back();
  if (values.size() > header.names.size()) {
    place.fail(std::to_string(values.size()) + " values in a line of " +
               std::to_string(header.names.size()) +
               " columns: decimal commas? Numbers must have a decimal point, and each column a "
               "name in the header");
  }
  return values;
}

void add_row(const Place& place, const Selection& selection,
             const std::vector<std::string_view>& fields, double& first_time, MotionTable& table) {
  for (std::size_t c = 0; c < selection.field.size(); ++c) {
    const std::string& name = selection.name[c];
    if (selection.field[c] >= fields.size()) {
      place.fail("column " + name + ": the line ends after " + std::to_string(fields.size()) +
                 " value(s); must be a finite number");
    }
    const std::string_view text = fields[selection.field[c]];
    const double value = number(place, name, text);
    if (c > 0) {
      table.values[c - 1].push_back(value);
      continue;
    }
    if (std::abs(value) > kLargestTime)
      place.fail(name, text, "must lie within +-9e9 s (ms, us or ns?)");
    if (table.time_s.empty()) first_time = value;
    const double time = value - first_time;
    if (time > kLargestTime) place.fail(name, text, "must be at most 9e9 s after the first row");
    if (!table.time_s.empty() && !(time - table.time_s.back() >= 1e-9)) {
      place.fail(name, text, "must be later than the row before it, by 1 ns or more");
    }
    table.time_s.push_back(time);
    table.line.push_back(place.line);
  }
}

/// Opens the file and reads its header into `line`.
std::ifstream open_with_header(const Place& place, std::string& line) {
  std::string why;
  const int opened = open_plain_file(place.file, kLargestFile, why);
  if (opened < 0) {
    place.fail(why + "; must be a CSV file with a header and a column time_s, at most 256 MB");
  }
  // The very file that was looked at, whatever its name stands for now.
  std::ifstream in("/proc/self/fd/" + std::to_string(opened), std::ios::binary);
  close(opened);
  if (!std::getline(in, line)) place.fail("is empty; must have a header and at least 2 rows");
  if (const auto zero = line.find('\0'); zero != std::string::npos) {
    const bool wide = zero < 3 || line.starts_with("\xFF\xFE");
    place.fail(wide ? "is UTF-16; must be saved as UTF-8" : "is no text; must be saved as CSV");
  }
  if (line.find('\r') < line.size() - 1) place.fail("its lines end with CR; must end with LF");
  return in;
}

std::string decimal(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

/// Units other than those of the names of the columns, as far as they show: a sentence each.
std::vector<std::string> doubts_about(const Place& place, const Selection& selection,
                                      const MotionTable& table) {
  std::vector<std::string> doubts;
  const auto doubt = [&](const std::string& column, const std::string& what) {
    doubts.push_back(place.file.string() + ": column " + column + ": " + what);
  };
  const double rows = static_cast<double>(table.time_s.size());
  if (table.time_s.back() / (rows - 1.0) >= kLongestRow) {
    doubt(std::string(kTime), decimal(rows) + " rows in " + decimal(table.time_s.back()) +
                                  " s: milliseconds or microseconds? must be in s");
  }
  for (std::size_t c = 0; c < table.values.size(); ++c) {
    const std::string& name = selection.name[c + 1];
    if (!name.ends_with("_rad")) continue;
    const auto [least, most] = std::minmax_element(table.values[c].begin(), table.values[c].end());
    if (*least >= kLeastBend && *most <= kMostBend) continue;
    doubt(name, "values to " + decimal(*most > kMostBend ? *most : *least) +
                    ": degrees? a finger's joints bend by " + decimal(kLeastBend) + " to " +
                    decimal(kMostBend) + " rad");
  }
  return doubts;
}

}  // namespace

const ColumnSet& joint_angle_columns() {
  static const ColumnSet kColumns{"q_o1_mcp_rad", "q_o2_pip_rad"};
  return kColumns;
}

bool is_gap(double a, double b) noexcept {
  return std::llround((b - a) * 1e9) > std::llround(kLongestStep * 1e9);
}

ColumnSet motion_columns(const std::filesystem::path& file) {
  Place place{file};
  std::string line;
  std::ifstream in = open_with_header(place, line);
  const Header header = header_of(line);
  return {header.names.begin(), header.names.end()};
}

MotionTable read_motion_csv(const std::filesystem::path& file,
                            const std::vector<ColumnSet>& alternatives) {
  Place place{file};
  std::string line;
  std::ifstream in = open_with_header(place, line);
  place.line = 1;
  const std::string first = line;
  const Header header = header_of(first);
  const Selection selection = select(place, header.names, alternatives);

  MotionTable table{.alternative = selection.alternative};
  table.values.resize(selection.name.size() - 1);
  double first_time = 0.0;
  while (std::getline(in, line)) {
    ++place.line;
    if (trimmed(line).empty()) continue;
    add_row(place, selection, values_of(place, line, header), first_time, table);
  }
  if (table.time_s.size() < 2) {
    Place{file}.fail("has " + std::to_string(table.time_s.size()) +
                     " row(s) below its header; must have at least 2");
  }
  table.doubts = doubts_about(place, selection, table);
  return table;
}

void require_range(const MotionTable& table, std::size_t column, const core::DofSpec& dof,
                   double lower, double upper, const std::filesystem::path& file) {
  const bool metres = dof.unit == core::Unit::kMetre;
  const double other = metres ? 1e-3 : 0.017453292519943295;  // mm or degrees
  for (std::size_t row = 0; row < table.time_s.size(); ++row) {
    const double value = table.values[column][row];
    if (value >= lower && value <= upper) continue;
    const bool fits = value * other >= lower && value * other <= upper;
    const char* const doubt = !fits ? "" : metres ? " m: millimetres?" : " rad: degrees?";
    Place{file, table.line[row]}.fail("column " + dof.name + " = " + decimal(value) +
                                      ": must lie within the device's range, " + decimal(lower) +
                                      " to " + decimal(upper) + doubt);
  }
}

}  // namespace haptic::hw
