#pragma once
/// Small scenes as text, and what the loader says of them.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "haptic/core/error.hpp"
#include "server/owner/scene/scene.hpp"
#include "server/owner/scene/shipped.hpp"
#include "tests/support/file_text.hpp"
#include "tests/support/message_of.hpp"

namespace haptic::test {

inline const std::filesystem::path kScenes =
    std::filesystem::path(HAPTIC_SOURCE_DIR) / "server/scenes";

/// A shipped scene's file, its text, and the scene that the loader makes of it.
inline std::filesystem::path shipped_file(const std::string& name) {
  return kScenes / (name + ".textproto");
}
inline std::string shipped_text(const std::string& name) {
  return file_text(shipped_file(name));
}
inline server::Scene shipped_scene(const std::string& name) {
  return server::load_scene(shipped_file(name));
}

inline std::vector<std::string> shipped_names() {
  std::vector<std::string> names;
  for (const server::ShippedScene& scene : server::shipped_scenes(kScenes)) {
    names.push_back(scene.name);
  }
  return names;
}

/// The shortest scene of a finger. Stiffness stands on line 7, the limits on line 9.
inline const std::string kFinger = R"(name: "t"
device {
  name: "finger"
  simulated_finger {}
  finger_exoskeleton {}
  impedance {
    stiffness_n_per_m: 1500
  }
  limits { force_n: 20 }
}
)";

/// Two DoFs, the second one sensed; one coordinate, and a prior for what it leaves free.
inline const std::string kLinear = R"(name: "t"
device {
  name: "d"
  simulated_linear { mass: [1, 2] max_effort: 5 }
  linear {
    dof { name: "s" unit: "m" actuated: true lower: -1 upper: 1 }
    dof { name: "r" unit: "rad" lower: -2 upper: 2 }
    coordinate { name: "x" unit: "m" }
    A: [1, 0.5]
  }
  impedance { stiffness_n_per_m: 5 }
  limits { force_n: 2 }
  prior { weight: 0.1 sensed_stiffness: 3 }
}
)";

inline server::Scene parse(const std::string& text, const std::vector<std::string>& set = {}) {
  return server::parse_scene(text, "t.textproto", kScenes, set);
}

/// The loader's message; "no error" where it found none.
inline std::string error_of(const std::string& text, const std::vector<std::string>& set = {}) {
  return message_of<core::SceneError>([&] { return parse(text, set); });
}

/// The loader's message must contain `says`, as it is here.
inline void expect_says(const std::string& text, const std::string& says,
                        const std::vector<std::string>& set = {}) {
  const std::string message = error_of(text, set);
  EXPECT_NE(message.find(says), std::string::npos) << "wanted: " << says << "\ngot:    " << message;
}

/// `part` stands in the scene's resolved text, and that reads back as the same scene.
inline void expect_resolved(const server::Scene& scene, const std::string& part) {
  EXPECT_NE(scene.resolved.find(part), std::string::npos) << scene.resolved;
  EXPECT_EQ(parse(scene.resolved).resolved, scene.resolved);
}

/// `text` with the first `from` replaced; there must be one.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// A device's scene with one more message in it.
inline std::string with_option(const std::string& text, const std::string& option) {
  return replaced(text, "limits {", option + "\n  limits {");
}

/// The finger played from a recording, and on a board.
inline const std::string kReplayed =
    replaced(kFinger, "simulated_finger {}",
             "replay { file: \"motion/reach_and_grasp.csv\" max_effort: 40 }");
inline const std::string kBoard =
    replaced(kFinger, "simulated_finger {}", "board { port: \"/dev/none\" max_effort: 40 }");

/// A scene that is wrong, and what the loader must say of it.
struct BadScene {
  const char* what;
  std::string text;
  std::string says;  ///< stands in the message, as it is here
};

inline void expect_each_says(const std::vector<BadScene>& table) {
  for (const BadScene& bad : table) {
    SCOPED_TRACE(bad.what);
    expect_says(bad.text, bad.says);
  }
}

/// A value that a field must not have, "path=value" as --set takes it, and what is allowed: "must
/// ...", or else what follows the path in the message.
struct BadValue {
  const std::string& text;
  std::string assignment;
  const char* rule;
};

inline void expect_each_value_says(const std::vector<BadValue>& table) {
  for (const BadValue& bad : table) {
    SCOPED_TRACE(bad.assignment);
    const std::size_t at = bad.assignment.find('=');
    const bool as_given = std::string(bad.rule).starts_with("must");
    const std::string value = as_given ? " = " + bad.assignment.substr(at + 1) + ": " : "";
    expect_says(bad.text, bad.assignment.substr(0, at) + value + bad.rule, {bad.assignment});
  }
}

}  // namespace haptic::test
