#pragma once
/// Everything that is wrong with a scene, collected, each with its place:
///
///     scene.textproto:12: device[0].impedance.stiffness_n_per_m[0] = -3: must be > 0
///     --set: loop.priority = 99: must be 1 to 98

#include <google/protobuf/text_format.h>

#include <string>
#include <vector>

namespace haptic::server {

/// One step of a path such as "device[0].impedance.stiffness_n_per_m[0]".
struct FieldStep {
  std::string text{};      ///< as written: "device[0]"
  std::string name{};      ///< "device"
  int index{-1};           ///< -1: none given
  bool well_formed{true};  ///< of the form name or name[number]
};

/// At least one step, whatever the text. An index has at most six digits.
[[nodiscard]] std::vector<FieldStep> split_path(const std::string& path);

class Problems {
 public:
  using Tree = google::protobuf::TextFormat::ParseInfoTree;

  /// `name` stands for the file; `root` and `tree` say on which line a field stands, and must
  /// outlive this.
  Problems(std::string name, const google::protobuf::Descriptor& root, const Tree& tree)
      : name_(std::move(name)), root_(root), tree_(tree) {}

  /// Fields at or below `path` come from the command line, not from the file.
  void came_from_command_line(const std::string& path) { overrides_.push_back(path); }

  /// "place: path = value: rule".
  void wrong(const std::string& path, const std::string& value, const std::string& rule);
  /// "place: path: is required: rule". The place is the message that lacks it.
  void missing(const std::string& path, const std::string& rule);
  /// A line that names its place itself.
  void add(std::string line);
  /// `n` problems that are counted, and not told.
  void add_untold(std::size_t n) noexcept { count_ += n; }

  /// Number of problems that are told; a file that is no scene may have 100,000.
  static constexpr std::size_t kMostTold = 100;

  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  /// Throws SceneError with one line per problem, if there is any, and how many more there are.
  void raise() const;

 private:
  [[nodiscard]] bool told() const noexcept { return lines_.size() < kMostTold; }
  [[nodiscard]] std::string place_of(const std::string& path) const;

  std::string name_;
  const google::protobuf::Descriptor& root_;
  const Tree& tree_;
  std::vector<std::string> overrides_{};
  std::vector<std::string> lines_{};
  std::size_t count_{0};
};

/// Shortest decimal that reads back as the same double.
[[nodiscard]] std::string decimal(double value);
/// In quotes, escaped, cut if it is long: safe on a terminal.
[[nodiscard]] std::string quoted(const std::string& text);
/// The whole text has the form of the regular expression, and at most 1024 bytes.
[[nodiscard]] bool matches(const std::string& text, const std::string& pattern);
/// Entry `i` of a list: "dof[3]".
[[nodiscard]] std::string entry(const std::string& list, std::size_t i);

}  // namespace haptic::server
