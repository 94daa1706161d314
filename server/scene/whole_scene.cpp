#include "server/scene/whole_scene.hpp"

#include "haptic/wire/utf8.hpp"
#include "server/base/figures.hpp"

namespace haptic::server {
namespace {

namespace fs = std::filesystem;
using google::protobuf::FieldDescriptor;

std::string device_path(std::size_t index) {
  return "device[" + std::to_string(index) + "]";
}

void check_one_text(const std::string& text, const std::string& path, Problems& problems) {
  if (!wire::is_utf8(text)) problems.wrong(path, quoted(text), "must be UTF-8");
}

/// The file that a device plays; empty: none.
fs::path played_by(const DeviceScene& device) {
  if (const auto* finger = std::get_if<hw::SimulatedFingerConfig>(&device.source)) {
    return finger->motion_file;
  }
  if (const auto* replay = std::get_if<hw::ReplayConfig>(&device.source)) return replay->file;
  return {};
}

bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code error;
  // By name too: a file that is not there yet has no identity.
  return fs::equivalent(a, b, error) ||
         fs::weakly_canonical(a, error) == fs::weakly_canonical(b, error);
}

}  // namespace

void check_text(const google::protobuf::Message& message, const std::string& path,
                Problems& problems) {
  const google::protobuf::Reflection& reflection = *message.GetReflection();
  std::vector<const FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    const std::string name = (path.empty() ? "" : path + ".") + field->name();
    const bool text = field->cpp_type() == FieldDescriptor::CPPTYPE_STRING;
    const bool nested = field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE;
    if (!field->is_repeated()) {
      if (text) check_one_text(reflection.GetString(message, field), name, problems);
      if (nested) check_text(reflection.GetMessage(message, field), name, problems);
      continue;
    }
    for (int i = 0; i < reflection.FieldSize(message, field); ++i) {
      const std::string entry = name + "[" + std::to_string(i) + "]";
      if (text) check_one_text(reflection.GetRepeatedString(message, field, i), entry, problems);
      if (nested) check_text(reflection.GetRepeatedMessage(message, field, i), entry, problems);
    }
  }
}

void check_paced_by(const v1::Scene& message, const Scene& scene, Problems& problems) {
  if (!message.loop().has_paced_by()) return;
  const std::string& name = message.loop().paced_by();
  std::string boards;
  for (const DeviceScene& device : scene.devices) {
    const bool board = std::holds_alternative<hw::BoardConfig>(device.source);
    if (device.name == name && board) return;
    if (device.name == name) {
      problems.wrong("loop.paced_by", quoted(name),
                     "must be a board: simulated and replayed devices have no clock of their own");
      return;
    }
    if (board) boards += (boards.empty() ? "" : ", ") + quoted(device.name);
  }
  problems.wrong("loop.paced_by", quoted(name),
                 boards.empty() ? "must be absent: the scene has no board"
                                : "must be the name of a board: " + boards);
}

void check_silence(const Scene& scene, Problems& problems) {
  for (std::size_t i = 0; i < scene.devices.size(); ++i) {
    const core::Duration fade_end = scene.devices[i].settings.staleness.fade_end;
    if (fade_end <= scene.server.lease_timeout) continue;
    problems.wrong(device_path(i) + ".staleness.fade_end", milliseconds(fade_end),
                   "must be at most server.lease_timeout, " +
                       milliseconds(scene.server.lease_timeout) + ": no lease ends under force");
  }
}

void check_recordings(const Scene& scene, Problems& problems) {
  if (!scene.record) return;
  for (std::size_t i = 0; i < scene.devices.size(); ++i) {
    const fs::path written = record_file(scene, i);
    for (const DeviceScene& device : scene.devices) {
      const fs::path played = played_by(device);
      if (played.empty() || !same_file(written, played)) continue;
      problems.wrong("record.file", quoted(scene.record->file.string()),
                     "must be another file: device '" + device.name + "' plays " + played.string() +
                         ", which would be overwritten");
    }
  }
}

}  // namespace haptic::server
