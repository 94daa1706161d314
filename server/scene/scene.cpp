#include "server/scene/scene.hpp"

#include <google/protobuf/text_format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>

#include "haptic/core/error.hpp"
#include "haptic/v1/scene.pb.h"
#include "server/scene/device_scene.hpp"
#include "server/scene/override.hpp"
#include "server/scene/problems.hpp"
#include "server/scene/text_format.hpp"

namespace haptic::server {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

std::string ms(core::Duration d) {
  return decimal(core::seconds(d) * 1e3) + " ms";
}

void check_between(core::Duration value, core::Duration lower, core::Duration upper,
                   const std::string& path, Problems& problems) {
  if (value < lower || value > upper) {
    problems.add(path, ms(value), "must be " + ms(lower) + " to " + ms(upper));
  }
}

void check_between(std::int64_t value, std::int64_t lower, std::int64_t upper,
                   const std::string& path, Problems& problems) {
  if (value < lower || value > upper) {
    problems.add(path, std::to_string(value),
                 "must be " + std::to_string(lower) + " to " + std::to_string(upper));
  }
}

bool is_address(const std::string& text) {
  if (text.rfind("unix:", 0) == 0) return text.size() > 5;
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == text.size()) return false;
  const std::string port = text.substr(colon + 1);
  if (port.size() > 5 || port.find_first_not_of("0123456789") != std::string::npos) return false;
  const std::string host = text.substr(0, colon);
  const bool bracketed = host.front() == '[' && host.back() == ']' && host.size() > 2;
  return std::stoi(port) <= 65535 && (bracketed || host.find(':') == std::string::npos);
}

ServerScene read_server(v1::ServerScene& message, Problems& problems) {
  ServerScene scene;
  if (message.listen().empty()) message.add_listen(scene.listen.front());
  scene.listen.assign(message.listen().begin(), message.listen().end());
  for (std::size_t i = 0; i < scene.listen.size(); ++i) {
    if (!is_address(scene.listen[i])) {
      problems.add("server.listen[" + std::to_string(i) + "]", "\"" + scene.listen[i] + "\"",
                   "must be host:port, [v6]:port (port 0 to 65535) or unix:/path");
    }
  }
  const bool has_lease = message.has_lease_timeout();
  scene.lease_timeout =
      read_duration(*message.mutable_lease_timeout(), has_lease, scene.lease_timeout);
  check_between(scene.lease_timeout, milliseconds(500), seconds(60), "server.lease_timeout",
                problems);
  if (!message.has_max_sessions()) message.set_max_sessions(scene.max_sessions);
  scene.max_sessions = message.max_sessions();
  check_between(scene.max_sessions, 1, 256, "server.max_sessions", problems);
  return scene;
}

LoopScene read_loop(v1::LoopScene& message, Problems& problems) {
  LoopScene scene;
  const bool has_period = message.has_period();
  scene.period = read_duration(*message.mutable_period(), has_period, scene.period);
  check_between(scene.period, std::chrono::microseconds(500), milliseconds(10), "loop.period",
                problems);
  if (message.has_loop_late_fault()) {
    scene.loop_late_fault = read_duration(*message.mutable_loop_late_fault(), true, {});
    check_between(*scene.loop_late_fault, 2 * scene.period, seconds(10), "loop.loop_late_fault",
                  problems);
  }
  if (!message.has_late_bucket_full()) message.set_late_bucket_full(scene.late_bucket_full);
  scene.late_bucket_full = message.late_bucket_full();
  check_between(scene.late_bucket_full, 10, 1'000'000, "loop.late_bucket_full", problems);
  if (!message.has_priority()) message.set_priority(scene.priority);
  scene.priority = message.priority();
  check_between(scene.priority, 1, 98, "loop.priority", problems);
  if (message.has_cpu()) {
    scene.cpu = message.cpu();
    check_between(message.cpu(), 0, 1023, "loop.cpu", problems);
  }
  return scene;
}

RecordScene read_record(const v1::RecordScene& message, Problems& problems) {
  const std::filesystem::path file(message.file());
  if (file.extension() != ".csv") {
    problems.add("record.file", "\"" + message.file() + "\"", "must be a file named *.csv");
  }
  return {file, message.compare_renderers()};
}

}  // namespace

Scene parse_scene(const std::string& text, const std::string& name,
                  const std::filesystem::path& folder, const std::vector<std::string>& overrides) {
  v1::Scene message;
  google::protobuf::TextFormat::ParseInfoTree tree;
  parse_text(text, name, message, tree);
  for (const std::string& assignment : overrides) apply_override(assignment, message);

  Problems problems(name, *v1::Scene::descriptor(), tree);
  Scene scene;
  scene.name = message.name();
  if (scene.name.empty()) problems.missing("name", "must be given");
  if (message.device().empty()) problems.missing("device", "at least one must be given");
  std::set<std::string> names;
  for (int i = 0; i < message.device_size(); ++i) {
    const std::string path = "device[" + std::to_string(i) + "]";
    scene.devices.push_back(read_device(*message.mutable_device(i), path, folder, problems));
    if (!names.insert(scene.devices.back().name).second) {
      problems.add(path + ".name", "\"" + scene.devices.back().name + "\"",
                   "another device has this name");
    }
  }
  scene.server = read_server(*message.mutable_server(), problems);
  scene.loop = read_loop(*message.mutable_loop(), problems);
  if (message.has_record()) scene.record = read_record(message.record(), problems);
  problems.raise();
  google::protobuf::TextFormat::PrintToString(message, &scene.resolved);
  return scene;
}

Scene load_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  std::ifstream stream(file);
  if (!stream || std::filesystem::is_directory(file)) {
    throw core::SceneError(
        file.string() + ": " +
        (std::filesystem::is_directory(file) ? "is a folder" : std::strerror(errno)) +
        "; must be a scene file that can be read");
  }
  std::stringstream text;
  text << stream.rdbuf();
  return parse_scene(text.str(), file.filename().string(), file.parent_path(), overrides);
}

}  // namespace haptic::server
