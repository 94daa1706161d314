#pragma once
/// Everything that is wrong with a scene, collected, each with the place it
/// stands in:
///   scene.textproto:12: device[0].impedance.stiffness_n_per_m[0] = -3: must be
///   finite and > 0
///   --set: loop.priority = 99: must be 1 to 98

#include <google/protobuf/text_format.h>

#include <string>
#include <vector>

namespace haptic::server {

class Problems {
 public:
  using Tree = google::protobuf::TextFormat::ParseInfoTree;

  /// `name` stands for the file; `root` and `tree` say on which line a field
  /// stands, and must outlive this.
  Problems(std::string name, const google::protobuf::Descriptor& root, const Tree& tree)
      : name_(std::move(name)), root_(root), tree_(tree) {}

  /// Fields at or below `path` come from the command line, not from the file.
  void came_from_command_line(const std::string& path) { overrides_.push_back(path); }

  /// "place: path = value: rule".
  void wrong(const std::string& path, const std::string& value, const std::string& rule);
  /// "place: path: is required: rule". The place is the message that lacks it.
  void missing(const std::string& path, const std::string& rule);
  /// A line that names its place itself.
  void add(std::string line) { lines_.push_back(std::move(line)); }

  [[nodiscard]] std::size_t count() const noexcept { return lines_.size(); }
  [[nodiscard]] bool any() const noexcept { return !lines_.empty(); }
  /// Throws SceneError with one line per problem, if there is any.
  void raise() const;

 private:
  [[nodiscard]] std::string place_of(const std::string& path) const;
  [[nodiscard]] bool overridden_at_or_below(const std::string& path) const;

  std::string name_;
  const google::protobuf::Descriptor& root_;
  const Tree& tree_;
  std::vector<std::string> overrides_{};
  std::vector<std::string> lines_{};
};

/// Shortest decimal that reads back as the same double.
[[nodiscard]] std::string decimal(double value);
/// In quotes, escaped, shortened where it is long: fit for a terminal.
[[nodiscard]] std::string quoted(const std::string& text);

}  // namespace haptic::server
