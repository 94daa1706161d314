#pragma once
/// Reads the fields of one message of a scene: fills in what is absent, in the message and in the
/// value it returns, and reports what is not allowed.

#include <google/protobuf/message.h>

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "haptic/core/time.hpp"
#include "haptic/core/types.hpp"
#include "server/scene/problems.hpp"

namespace haptic::server {

/// Values that a number may have; always finite.
enum class Allowed : std::uint8_t { kFinite, kNotNegative, kPositive };

/// A list with one number per something.
struct ListField {
  const char* name;  ///< in scene.proto
  Allowed allowed;
  int size;         ///< how many there must be; -1: unknown, because what decides it is wrong
  const char* per;  ///< kPerActuatedDof, "coordinate", ...
};
inline constexpr const char* kPerActuatedDof = "actuated DoF";

/// An optional number and the value it stands for, which holds its default.
struct NumberField {
  const char* name;
  double* value;
  Allowed allowed;
};

struct DurationRange {
  core::Duration lowest{};
  core::Duration highest{};
};

class FieldReader {
 public:
  /// `path` is the message's: "device[0].impedance". All must outlive this.
  FieldReader(google::protobuf::Message& message, std::string path, Problems& problems);

  void wrong(const std::string& field, const std::string& value, const std::string& why) const;
  void missing(const std::string& field, const std::string& why) const;
  [[nodiscard]] std::string path(const std::string& field) const;

  /// Reads each number that is present; writes the default of each that is absent.
  void numbers(std::initializer_list<NumberField> fields) const;
  /// `fallback` replaces an empty list; without it the list is required. Empty if the size is
  /// wrong.
  [[nodiscard]] std::vector<double> list(
      const ListField& field, const std::optional<std::vector<double>>& fallback = {}) const;
  /// The duration in `range`; `fallback` goes into the message if it is absent.
  [[nodiscard]] core::Duration duration(const std::string& field, core::Duration fallback,
                                        const DurationRange& range) const;
  /// The same without a default.
  [[nodiscard]] std::optional<core::Duration> duration(const std::string& field,
                                                       const DurationRange& range) const;
  /// Reports unless lowest <= value <= highest.
  void whole_number(const std::string& field, std::int64_t value, std::int64_t lowest,
                    std::int64_t highest) const;
  /// A file that is read, relative to `folder`: its full path, which goes into the message. Empty
  /// if the field is; reports one that is not there: "must be `what`; there is none at ...".
  [[nodiscard]] std::filesystem::path file(const char* field, const std::filesystem::path& folder,
                                           const std::string& what) const;
  /// The message's `name`, of a DoF, coordinate, joint or finger, which becomes a column of
  /// recordings. Reports unless it is 1 to `longest` letters, digits, _ and -, and not in `taken`,
  /// to which it is added.
  void entry_name(std::size_t longest, std::set<std::string>& taken) const;

 private:
  [[nodiscard]] const google::protobuf::FieldDescriptor& find(const std::string& field) const;
  void check(const std::string& field, double value, Allowed allowed) const;

  google::protobuf::Message& message_;
  std::string path_;
  Problems& problems_;
};

/// One value per DoF; empty if there are more than core can hold.
[[nodiscard]] core::VecQ to_vector(const std::vector<double>& values);
/// "[1500, 1500]", or "[30 values]".
[[nodiscard]] std::string decimal(const std::vector<double>& values);

}  // namespace haptic::server
