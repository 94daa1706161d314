#pragma once
/// Reads recordings: CSV with a header line, a column time_s and columns of numbers. Accepts
/// semicolons and tabs instead of commas, quotes, CRLF, a byte order mark, blank lines, extra
/// columns (not looked at) and any order of columns.

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "haptic/core/model/kinematics.hpp"

namespace haptic::hw {

/// Names of the columns that are needed besides time_s.
using ColumnSet = std::vector<std::string>;

/// The joint angles of a finger, rad, flexion positive.
[[nodiscard]] const ColumnSet& joint_angle_columns();

struct MotionTable {
  std::size_t alternative{0};                 ///< which of the column sets asked for it holds
  std::vector<double> time_s{};               ///< from 0, strictly increasing by 1 ns or more
  std::vector<std::vector<double>> values{};  ///< by column of the set, then by row; finite
  std::vector<std::size_t> line{};            ///< line of the file a row stood on, from 1
  /// For people: columns that look like degrees or milliseconds, with the largest value.
  std::vector<std::string> doubts{};
};

/// A step of time longer than this is a gap in which nothing was measured, for example because a
/// tracker lost the hand. Jitter of recordings stays below 40 ms.
inline constexpr double kLongestStep = 0.050;  // s
/// True if the step from a to b (s) is a gap. Compared in whole nanoseconds, so that a step of 50
/// ms is none in spite of rounding.
[[nodiscard]] bool is_gap(double a, double b) noexcept;

/// The columns that the header of `file` names. Throws DeviceError as read_motion_csv() does.
[[nodiscard]] ColumnSet motion_columns(const std::filesystem::path& file);

/// The first of `alternatives` whose columns are all in `file`. Throws DeviceError naming the file,
/// line, column, value and what is expected: no regular file, above 256 MB (said before any of it
/// is read), empty, UTF-16, no text, a column missing (with the columns found) or twice, a line of
/// more values than columns, not a finite number, time not increasing, fewer than 2 rows.
[[nodiscard]] MotionTable read_motion_csv(const std::filesystem::path& file,
                                          const std::vector<ColumnSet>& alternatives);

/// Throws DeviceError naming file, line, column and value unless every value of `column`, that of
/// `dof`, lies within lower..upper; a value that would as millimetres or degrees is doubted.
void require_range(const MotionTable& table, std::size_t column, const core::DofSpec& dof,
                   double lower, double upper, const std::filesystem::path& file);

}  // namespace haptic::hw
