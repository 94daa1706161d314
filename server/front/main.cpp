/// hapticd-front: what faces the network. hapticd starts it, with a socket as descriptor 3.
/// Exit status: 0 told to leave, or checked; 1 could not serve; 2 not started by hapticd.

#include <fcntl.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <iostream>
#include <optional>

#include "haptic/core/error.hpp"
#include "server/base/log.hpp"
#include "server/base/version.hpp"
#include "server/front/app.hpp"
#include "server/front/confinement.hpp"
#include "server/front/session/owner_link.hpp"
#include "server/owner/state/device_message.hpp"
#include "server/owner/state/state_message.hpp"

#if defined(__SANITIZE_ADDRESS__)
// The leak checker traces its own process, which a confined one may not.
extern "C" int __lsan_is_turned_off() {  // NOLINT(bugprone-reserved-identifier): its name
  return 1;
}
#endif

namespace {

using namespace haptic::server;

constexpr int kLink = 3;

struct CommandLine {
  std::vector<std::string> listen{};
  std::string log_level{"info"};
  std::string log_format{"text"};
  std::string check_tls{};
  bool insecure_lab{false};
};

/// The owner's word about the devices, as the rest of the front wants it.
std::vector<DeviceFacts> facts_of(const Scene& scene, const std::string& descriptions) {
  const auto devices = devices_of(descriptions);
  if (devices.size() != scene.devices.size()) {
    throw haptic::core::TransportError("the owner's devices are not the scene's");
  }
  std::vector<DeviceFacts> facts;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const DeviceScene& device = scene.devices[i];
    facts.push_back({device.name, devices[i], &device.pipeline, scene.server.lease_timeout,
                     largest_state(device.pipeline)});
  }
  return facts;
}

ConfinedFiles files_of(const Scene& scene) {
  ConfinedFiles files;
  if (scene.server.tls) {
    files.read = {scene.server.tls->certificate, scene.server.tls->key};
    if (!scene.server.tls->client_ca.empty()) files.read.push_back(scene.server.tls->client_ca);
  }
  std::vector<std::string> addresses = scene.server.listen;
  if (scene.server.web) {
    const auto& web = scene.server.web->listen;
    addresses.insert(addresses.end(), web.begin(), web.end());
    for (const auto& token : scene.server.web->tokens) files.read.push_back(token.file);
  }
  for (const std::string& address : addresses) {
    constexpr std::string_view kUnix = "unix:";
    if (address.rfind(kUnix, 0) != 0) continue;
    files.sockets.push_back(std::filesystem::absolute(address.substr(kUnix.size())).parent_path());
  }
  return files;
}

void begin_log(const CommandLine& line) {
  log_to_stderr(line.log_format == "json" ? LogFormat::kJson : LogFormat::kText);
  spdlog::set_level(spdlog::level::from_str(line.log_level));
}

/// Those that the front before this one had bound, in place of the scene's: the same ports.
void take_over(const std::vector<std::string>& addresses, ServerScene& scene) {
  std::size_t next = 0;
  const auto take = [&](std::string& address) {
    if (next < addresses.size()) address = addresses[next++];
  };
  for (std::string& address : scene.listen) take(address);
  if (scene.web) {
    for (std::string& address : scene.web->listen) take(address);
  }
  if (!scene.metrics_listen.empty()) take(scene.metrics_listen);
}

/// Until the owner wants no front any more; throws what keeps it from serving.
void serve(OwnerLink& owner, const CommandLine& line) {
  Scene scene = parse_scene(owner.scene(), "the owner's scene", "/");
  if (!line.listen.empty()) scene.server.listen = line.listen;
  owner.set_devices(facts_of(scene, owner.device_descriptions()));
  FrontApp::check(scene);
  Page page;
  if (scene.server.web)
    page = load_page(page_folder(std::filesystem::read_symlink("/proc/self/exe")));
  const std::vector<std::string> missing = confine(files_of(scene));
  begin_log(line);  // has a thread
  for (const std::string& sentence : missing)
    spdlog::warn("confinement of the front: {}", sentence);
  FrontSources sources;
  sources.owner = &owner;
  sources.facts = [&owner] { return owner.facts(); };
  sources.totals = [&owner](std::size_t device) { return owner.totals(device); };
  sources.count = [&owner](const FrontCounters& own) { return owner.count(own); };
  owner.ready();
  std::vector<std::string> addresses;
  if (!owner.wait_for_go(addresses)) return;
  take_over(addresses, scene.server);
  FrontApp app(scene, line.insecure_lab, sources, std::move(page));
  owner.begin();
  app.start();
  owner.serving(app.addresses());
  owner.wait_for_leave();
  app.stop();
  owner.stop();
}

int run(const CommandLine& line) {
  std::optional<OwnerLink> owner;
  try {
    owner.emplace(Descriptor(kLink));
  } catch (const std::exception& error) {
    std::cerr << "hapticd-front: " << error.what() << "\n";
    return 2;
  }
  try {
    serve(*owner, line);
    finish_log();
    return 0;
  } catch (const std::exception& error) {
    owner->cannot_serve(error.what());
    finish_log();
    return 1;
  }
}

int check_tls(const std::string& scene) {
  try {
    FrontApp::check(load_scene(scene));
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "hapticd: " << error.what() << "\n";
    return 1;
  }
}

}  // namespace

int main(int argc, char** argv) {
  // Ctrl-C in a terminal reaches every process of it; hapticd ends its front by itself.
  for (const int ignored : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(ignored, SIG_IGN);
  CommandLine line;
  CLI::App cli("hapticd-front - faces the network for hapticd, which starts it", "hapticd-front");
  cli.set_version_flag("--version", std::string("hapticd-front ") + version());
  cli.add_option("--listen", line.listen, "instead of the scene's addresses");
  cli.add_option("--log-level", line.log_level);
  cli.add_option("--log-format", line.log_format);
  cli.add_flag("--insecure-lab", line.insecure_lab);
  cli.add_option("--check-tls", line.check_tls, "check the files of TLS that this scene names");
  CLI11_PARSE(cli, argc, argv);
  if (!line.check_tls.empty()) return check_tls(line.check_tls);
  if (fcntl(kLink, F_GETFD) < 0) {
    std::cerr << "hapticd-front: hapticd starts it\n";
    return 2;
  }
  return run(line);
}
