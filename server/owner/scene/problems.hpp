#pragma once
/// Everything that is wrong with a scene, collected, each with its place:
///
///     scene.textproto:12: device[0].impedance.stiffness_n_per_m[0] = -3: must be > 0
///     --set: loop.priority = 99: must be 1 to 98

#include <google/protobuf/text_format.h>

#include <string>
#include <vector>

namespace haptic::server {

/// A field of a message, or one entry of a list.
struct FieldStep {
  FieldStep(const char* field) : name(field) {}
  FieldStep(std::string field) : name(std::move(field)) {}
  FieldStep(std::string list, std::size_t entry)
      : name(std::move(list)), index(static_cast<int>(entry)) {}

  std::string name;
  int index{-1};  ///< -1: the field as a whole
};

/// From the scene inwards.
using FieldPath = std::vector<FieldStep>;
/// "device[0].impedance.stiffness_n_per_m[0]".
[[nodiscard]] std::string text(const FieldPath& path);

class Problems {
 public:
  using Tree = google::protobuf::TextFormat::ParseInfoTree;

  /// `name` stands for the file; `root` and `tree` say on which line a field stands, and must
  /// outlive this.
  Problems(std::string name, const google::protobuf::Descriptor& root, const Tree& tree)
      : name_(std::move(name)), root_(root), tree_(tree) {}

  /// Fields at or below `path` come from the command line, not from the file.
  void came_from_command_line(FieldPath path) { overrides_.push_back(std::move(path)); }

  /// "place: path = value: rule".
  void wrong(const FieldPath& path, const std::string& value, const std::string& rule);
  /// "place: path: is required: rule". The place is the message that lacks it.
  void missing(const FieldPath& path, const std::string& rule);
  /// A line that names its place itself.
  void add(std::string line);
  /// Ends the newest problem with what to write instead.
  void advise(const std::string& instead);
  /// `n` problems that are counted, and not told.
  void add_untold(std::size_t n) noexcept { count_ += n; }

  /// Number of problems that are told; a file that is no scene may have 100,000.
  static constexpr std::size_t kMostTold = 100;

  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  /// Throws SceneError with one line per problem, if there is any, and how many more there are.
  void raise() const;

 private:
  [[nodiscard]] bool told() const noexcept { return lines_.size() < kMostTold; }
  [[nodiscard]] std::string place_of(const FieldPath& path) const;

  std::string name_;
  const google::protobuf::Descriptor& root_;
  const Tree& tree_;
  std::vector<FieldPath> overrides_{};
  std::vector<std::string> lines_{};
  std::size_t count_{0};
};

/// Shortest decimal that reads back as the same double.
[[nodiscard]] std::string decimal(double value);
/// In quotes, escaped, cut if it is long: safe on a terminal.
[[nodiscard]] std::string quoted(const std::string& text);
/// The whole text has the form of the regular expression, and at most 1024 bytes.
[[nodiscard]] bool matches(const std::string& text, const std::string& pattern);

}  // namespace haptic::server
