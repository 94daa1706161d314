#include "server/owner/scene/scene.hpp"

#include <google/protobuf/text_format.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "haptic/core/error.hpp"
#include "haptic/wire/utf8.hpp"
#include "hw/plain_file.hpp"
#include "server/base/figures.hpp"
#include "server/crossing/shared_layout.hpp"
#include "server/owner/scene/parts.hpp"
#include "server/owner/scene/text.hpp"

namespace haptic::server {
namespace {

namespace fs = std::filesystem;
using google::protobuf::FieldDescriptor;

constexpr std::size_t kLongestName = 64;

/// Applies every override, so that all that are wrong are named.
void apply(const std::vector<std::string>& overrides, v1::Scene& message, Problems& problems) {
  bool refused = false;
  for (const std::string& assignment : overrides) {
    try {
      problems.came_from_command_line(apply_override(assignment, message));
    } catch (const core::SceneError& error) {
      problems.add("--set " + assignment + ": " + error.what());
      refused = true;
    }
  }
  if (refused) problems.raise();  // what else is wrong may come of it
}

void check_name(const Part<v1::Scene>& scene) {
  const std::string& name = scene->name();
  const bool one_line =
      std::none_of(name.begin(), name.end(), [](unsigned char c) { return std::iscntrl(c) != 0; });
  if (name.empty()) {
    scene.missing("name", "what people call this scene");
  } else if (name.size() > kLongestName || !one_line) {
    scene.wrong("name", quoted(name),
                "must be 1 to " + std::to_string(kLongestName) + " characters on one line");
  }
}

std::vector<DeviceScene> read_devices(const Part<v1::Scene>& scene) {
  if (scene->device().empty()) scene.missing("device", "at least one");
  if (static_cast<std::size_t>(scene->device().size()) > kMostDevices) {
    scene.wrong("device", std::to_string(scene->device().size()) + " of them",
                "must be at most " + std::to_string(kMostDevices));
  }
  std::vector<DeviceScene> devices;
  std::set<std::string> names;
  for (const auto& part : scene.parts<v1::DeviceScene>("device")) {
    devices.push_back(read_device(part));
    const std::string& name = devices.back().name;
    if (!names.insert(name).second) {
      part.wrong("name", quoted(name), "must be another: this one is taken");
    }
  }
  return devices;
}

/// The message with every default, under a comment on what has none.
std::string printed(const v1::Scene& message) {
  google::protobuf::TextFormat::Printer printer;
  printer.SetUseShortRepeatedPrimitives(true);
  std::string text;
  printer.PrintToString(message, &text);
  return "# proto-file: haptic/v1/scene.proto\n"
         "# proto-message: haptic.v1.Scene\n"
         "#\n"
         "# Every default is filled in, except those that are decided later: staleness.fresh_end "
         "(2.5 periods\n"
         "# of the client) and, with hardware, loop.loop_late_fault (8 ms with real-time "
         "scheduling, 20 ms\n"
         "# without). Without hardware, only simulated and replayed devices, the loop's limits on "
         "lateness\n"
         "# are wide, because a late tick can hurt no one.\n" +
         text;
}

bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code error;
  // Compares by name too: a file that is not there yet has no identity.
  return fs::equivalent(a, b, error) ||
         fs::weakly_canonical(a, error) == fs::weakly_canonical(b, error);
}

/// Every text must be UTF-8: protobuf refuses to send anything else.
void check_text(const google::protobuf::Message& message, const FieldPath& path,
                Problems& problems) {
  const google::protobuf::Reflection& reflection = *message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const bool list = field->is_repeated();
    for (int i = 0; i < (list ? reflection.FieldSize(message, field) : 1); ++i) {
      FieldPath at = path;
      at.push_back(list ? FieldStep(field->name(), static_cast<std::size_t>(i)) : field->name());
      if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
        check_text(list ? reflection.GetRepeatedMessage(message, field, i)
                        : reflection.GetMessage(message, field),
                   at, problems);
      } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
        const std::string text = list ? reflection.GetRepeatedString(message, field, i)
                                      : reflection.GetString(message, field);
        if (!wire::is_utf8(text)) problems.wrong(at, quoted(text), "must be UTF-8");
      }
    }
  }
}

/// Only a device with a sample clock can pace the loop; its period is checked when it is open
/// (check_pacing).
void check_paced_by(const v1::Scene& message, const Scene& scene, Problems& problems) {
  if (!message.loop().has_paced_by()) return;
  const std::string& name = message.loop().paced_by();
  std::string clocks;
  for (const DeviceScene& device : scene.devices) {
    if (device.source == nullptr || !device.source->has_sample_clock()) continue;
    if (device.name == name) return;
    clocks += (clocks.empty() ? "" : ", ") + quoted(device.name);
  }
  problems.wrong({"loop", "paced_by"}, quoted(name),
                 clocks.empty() ? "must be absent: no device of the scene has a sample clock"
                                : "must be a device with a sample clock: " + clocks);
}

/// Silence must end the force before it ends the lease (proto/README.md#states-of-a-device).
void check_silence(const Scene& scene, Problems& problems) {
  for (std::size_t i = 0; i < scene.devices.size(); ++i) {
    const core::Duration fade_end = scene.devices[i].pipeline.scene.staleness.fade_end;
    if (fade_end <= scene.server.lease_timeout) continue;
    problems.wrong({{"device", i}, "staleness", "fade_end"}, milliseconds(fade_end),
                   "must be at most server.lease_timeout, " +
                       milliseconds(scene.server.lease_timeout) + ": no lease ends under force");
  }
}

/// A recording must not overwrite a file that the scene plays.
void check_recordings(const Scene& scene, Problems& problems) {
  if (!scene.record) return;
  for (std::size_t i = 0; i < scene.devices.size(); ++i) {
    const fs::path written = record_file(scene, i);
    for (const DeviceScene& device : scene.devices) {
      const fs::path played = device.source ? device.source->plays() : fs::path{};
      if (played.empty() || !same_file(written, played)) continue;
      problems.wrong({"record", "file"}, quoted(scene.record->file.string()),
                     "must be another file: device '" + device.name + "' plays " + played.string() +
                         ", which would be overwritten");
    }
  }
}

}  // namespace

Scene parse_scene(const std::string& text, const std::string& name, const fs::path& folder,
                  const std::vector<std::string>& overrides) {
  v1::Scene message;
  Problems::Tree tree;
  Problems problems(name, *v1::Scene::descriptor(), tree);
  parse_text(text, name, message, tree, problems);
  apply(overrides, message, problems);

  check_text(message, {}, problems);
  const Part<v1::Scene> part(message, {}, folder, problems);
  Scene scene;
  check_name(part);
  scene.name = message.name();
  scene.devices = read_devices(part);
  scene.server = read_server(part.part<v1::ServerScene>("server"));
  scene.loop = read_loop(part.part<v1::LoopScene>("loop"), scene.devices);
  if (message.has_record()) scene.record = read_record(part.part<v1::RecordScene>("record"));
  check_paced_by(message, scene, problems);
  check_silence(scene, problems);
  check_recordings(scene, problems);
  problems.raise();
  scene.resolved = printed(message);
  scene.warnings = safeguard_warnings(scene);
  for (std::string& warning : passivity_warnings(scene)) {
    scene.warnings.push_back(std::move(warning));
  }
  return scene;
}

fs::path record_file(const Scene& scene, std::size_t device) {
  const fs::path& file = scene.record->file;
  if (scene.devices.size() <= 1) return file;
  fs::path own = file;
  own.replace_filename(file.stem().string() + "-" + scene.devices[device].name +
                       file.extension().string());
  return own;
}

Scene load_scene(const fs::path& file, const std::vector<std::string>& overrides) {
  std::string why;
  const std::string text = hw::read_plain_file(file, kLargestScene, why);
  if (!why.empty()) {
    throw core::SceneError(file.string() + ": " + why + "; must be a scene that can be read");
  }
  return parse_scene(text, file.string(), file.parent_path(), overrides);
}

}  // namespace haptic::server
