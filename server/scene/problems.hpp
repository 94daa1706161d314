#pragma once
/// Everything that is wrong with a scene, collected, with the line it stands on:
///   scene.textproto:12: device[0].impedance.stiffness_n_per_m[0] = -3: must be > 0

#include <google/protobuf/message.h>
#include <google/protobuf/text_format.h>

#include <string>
#include <vector>

namespace haptic::server {

class Problems {
 public:
  /// `name` stands for the file; `root` and `tree` say where a field stands. All must outlive this.
  Problems(std::string name, const google::protobuf::Descriptor& root,
           const google::protobuf::TextFormat::ParseInfoTree& tree)
      : name_(std::move(name)), root_(root), tree_(tree) {}

  void add(const std::string& path, const std::string& value, const std::string& allowed);
  void add(const std::string& path, double value, const std::string& allowed);
  void missing(const std::string& path, const std::string& wanted);
  [[nodiscard]] bool any() const noexcept { return !lines_.empty(); }
  /// Throws SceneError with one line per problem, if there is any.
  void raise() const;

 private:
  /// Line of the field, or of the nearest message around it that stands in the file; 0: none does.
  [[nodiscard]] int line_of(const std::string& path) const;
  std::string name_;
  const google::protobuf::Descriptor& root_;
  const google::protobuf::TextFormat::ParseInfoTree& tree_;
  std::vector<std::string> lines_{};
};

/// Shortest decimal that reads back as the same double.
[[nodiscard]] std::string decimal(double value);

}  // namespace haptic::server
