#include "server/scene/scene.hpp"

#include <google/protobuf/text_format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>

#include "haptic/core/error.hpp"
#include "haptic/v1/scene.pb.h"
#include "server/scene/daemon_scene.hpp"
#include "server/scene/device_scene.hpp"
#include "server/scene/override.hpp"
#include "server/scene/passivity_warning.hpp"
#include "server/scene/problems.hpp"
#include "server/scene/text_format.hpp"
#include "server/scene/whole_scene.hpp"

namespace haptic::server {
namespace {

constexpr std::size_t kLongestName = 64;

/// Applies every override, so that all that are wrong are named.
void apply(const std::vector<std::string>& overrides, v1::Scene& message, Problems& problems) {
  bool refused = false;
  for (const std::string& assignment : overrides) {
    try {
      problems.came_from_command_line(apply_override(assignment, message));
    } catch (const core::SceneError& error) {
      problems.add(error.what());
      refused = true;
    }
  }
  if (refused) problems.raise();  // what else is wrong may come of it
}

bool is_one_line(const std::string& text) {
  return std::none_of(text.begin(), text.end(),
                      [](unsigned char c) { return std::iscntrl(c) != 0; });
}

void read_name(const std::string& name, Problems& problems) {
  if (name.empty()) {
    problems.missing("name", "what people call this scene");
  } else if (name.size() > kLongestName || !is_one_line(name)) {
    problems.wrong("name", quoted(name),
                   "must be 1 to " + std::to_string(kLongestName) + " characters on one line");
  }
}

std::vector<DeviceScene> read_devices(v1::Scene& message, const std::filesystem::path& folder,
                                      Problems& problems) {
  if (message.device().empty()) problems.missing("device", "at least one");
  std::vector<DeviceScene> devices;
  std::set<std::string> names;
  for (int i = 0; i < message.device_size(); ++i) {
    const std::string path = "device[" + std::to_string(i) + "]";
    devices.push_back(read_device(*message.mutable_device(i), path, folder, problems));
    const std::string& name = devices.back().name;
    if (!names.insert(name).second) {
      problems.wrong(path + ".name", quoted(name), "must be another: this one is taken");
    }
  }
  return devices;
}

/// The message with every default, and a word on what has none.
std::string printed(const v1::Scene& message) {
  google::protobuf::TextFormat::Printer printer;
  printer.SetUseShortRepeatedPrimitives(true);
  std::string text;
  printer.PrintToString(message, &text);
  return "# proto-file: haptic/v1/scene.proto\n"
         "# proto-message: haptic.v1.Scene\n"
         "#\n"
         "# Every default is filled in, except those that are decided later: loop.loop_late_fault "
         "(8 ms\n"
         "# with real-time scheduling, 20 ms without) and staleness.fresh_end (2.5 periods of the\n"
         "# client).\n" +
         text;
}

}  // namespace

Scene parse_scene(const std::string& text, const std::string& name,
                  const std::filesystem::path& folder, const std::vector<std::string>& overrides) {
  v1::Scene message;
  Problems::Tree tree;
  Problems problems(name, *v1::Scene::descriptor(), tree);
  parse_text(text, name, message, tree, problems);
  apply(overrides, message, problems);

  check_text(message, "", problems);
  Scene scene;
  read_name(message.name(), problems);
  scene.name = message.name();
  scene.devices = read_devices(message, folder, problems);
  scene.server = read_server(*message.mutable_server(), folder, problems);
  scene.loop = read_loop(*message.mutable_loop(), problems);
  if (message.has_record()) scene.record = read_record(*message.mutable_record(), problems);
  check_paced_by(message, scene, problems);
  check_silence(scene, problems);
  check_recordings(scene, problems);
  problems.raise();
  scene.resolved = printed(message);
  scene.warnings = passivity_warnings(scene);
  return scene;
}

std::filesystem::path record_file(const Scene& scene, std::size_t device) {
  const std::filesystem::path& file = scene.record->file;
  if (scene.devices.size() <= 1) return file;
  std::filesystem::path own = file;
  own.replace_filename(file.stem().string() + "-" + scene.devices[device].name +
                       file.extension().string());
  return own;
}

Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  std::error_code error;
  const bool regular = std::filesystem::is_regular_file(file, error);
  std::ifstream stream(file);
  if (!regular || !stream) {
    const std::string why = std::filesystem::is_directory(file, error) ? "is a folder"
                            : errno != 0                               ? std::strerror(errno)
                                                                       : "is no file";
    throw core::SceneError(file.string() + ": " + why + "; must be a scene that can be read");
  }
  std::stringstream text;
  text << stream.rdbuf();
  return parse_scene(text.str(), file.string(), file.parent_path(), overrides);
}

}  // namespace haptic::server
