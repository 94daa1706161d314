#pragma once
/// Reads the numbers, lists and durations of one message of a scene: fills in
/// what is absent, in the message and in the value it returns, and reports what
/// is not allowed.

#include <google/protobuf/message.h>

#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "haptic/core/time.hpp"
#include "haptic/core/types.hpp"
#include "server/scene/problems.hpp"

namespace haptic::server {

/// What a number may be; finite in any case.
enum class Allowed : std::uint8_t { kFinite, kNotNegative, kPositive };

/// A list with one number per something.
struct ListField {
  const char* name;  ///< in scene.proto
  Allowed allowed;
  int size;         ///< how many there must be; -1: not known, because what it derives
                    ///< from is wrong
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

  /// Each number as it is in the message where it is there, else its default
  /// into the message.
  void numbers(std::initializer_list<NumberField> fields) const;
  /// `fallback` takes the place of an empty list; without one a list is
  /// required. Empty where the size is wrong.
  [[nodiscard]] std::vector<double> list(
      const ListField& field, const std::optional<std::vector<double>>& fallback = {}) const;
  /// The duration in `range`; `fallback` goes into the message where it is
  /// absent.
  [[nodiscard]] core::Duration duration(const std::string& field, core::Duration fallback,
                                        const DurationRange& range) const;
  /// The same without a default.
  [[nodiscard]] std::optional<core::Duration> duration(const std::string& field,
                                                       const DurationRange& range) const;
  /// Reports unless lowest <= value <= highest.
  void whole_number(const std::string& field, std::int64_t value, std::int64_t lowest,
                    std::int64_t highest) const;

 private:
  [[nodiscard]] const google::protobuf::FieldDescriptor& find(const std::string& field) const;
  void check(const std::string& field, double value, Allowed allowed) const;

  google::protobuf::Message& message_;
  std::string path_;
  Problems& problems_;
};

/// One value per DoF; empty where there are more than core holds.
[[nodiscard]] core::VecQ to_vector(const std::vector<double>& values);
/// "[1500, 1500]", or "[30 values]".
[[nodiscard]] std::string decimal(const std::vector<double>& values);

}  // namespace haptic::server
