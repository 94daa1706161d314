#include "server/owner/link/front_program.hpp"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "haptic/core/error.hpp"
#include "server/crossing/link_messages.hpp"
#include "server/owner/link/front_link.hpp"

namespace haptic::server {
namespace {

// Room for 32 sessions and 32 watches with full queues, several times over; a thread needs less
// than half of its stack.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::size_t kMemory = 0, kStack = 0;
#else
constexpr std::size_t kMemory = std::size_t{512} << 20U;
constexpr std::size_t kStack = std::size_t{1} << 20U;
#endif

std::shared_ptr<HandOver> hand_over(const App& app) {
  const ServerScene& scene = app.scene().server;
  const std::filesystem::path page = scene.web ? page_folder(front_program()) : "";
  return std::make_shared<HandOver>(front_config(app), scene, page);
}

/// kHello if it says nothing in time, or ends.
FrontMessage next_message(const FrontProcess& front) {
  pollfd wait{front.link.get(), POLLIN, 0};
  poll(&wait, 1, static_cast<int>(FrontLink::kStarting / std::chrono::milliseconds(1)));
  FrontMessage message;
  static_cast<void>(receive(front.link.get(), message));
  return message;
}

}  // namespace

std::filesystem::path front_program() {
  if (const char* const given = std::getenv("HAPTICD_FRONT")) return given;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe");
  const std::filesystem::path beside = own.parent_path() / "hapticd-front";
  const std::filesystem::path installed =
      own.parent_path().parent_path() / "libexec" / "hapticd" / "hapticd-front";
  for (const auto& path : {beside, installed}) {
    if (access(path.c_str(), X_OK) == 0) return path;
  }
  throw core::TransportError("hapticd-front is neither at " + beside.string() + " nor at " +
                             installed.string());
}

FrontLimits front_limits(const Scene& scene) {
  return {kMemory, kStack, 1, scene.loop.cpu};
}

std::unique_ptr<FrontRunner> front_process(App& app, Launcher* launcher,
                                           std::function<void()> lost) {
  return std::make_unique<FrontLink>(
      app.owner(),
      FrontLink::Config{launcher, launcher != nullptr ? hand_over(app) : nullptr, app.scene().name,
                        [&app] { return app.facts(); }, app.tick_metrics(),
                        app.realtime().facts.sched_fifo, std::move(lost)});
}

FrontConfig front_config(const App& app) {
  FrontConfig config = front_config(app.scene().server, app.options().insecure_lab);
  config.scene = app.scene().name;
  config.log_level = app.options().log_level;
  config.period = app.scene().loop.period;
  config.devices = app.owner().devices();
  return config;
}

std::string check_front_files(const Scene& scene) {
  FrontConfig config = front_config(scene.server, false);
  config.log_level = "error";
  if (!config.tls && (!config.web || config.web->tokens.empty())) return {};
  const std::filesystem::path program = front_program();
  if (access(program.c_str(), X_OK) != 0) {
    throw core::TransportError(program.string() + ": " + std::strerror(errno));
  }
  const std::vector<Descriptor> files = open_files(config, page_folder(program));
  const SharedMemory bytes = to_memory(config);
  const SharedMemory pages("haptic-check", OwnersPages::bytes(0));
  FrontProcess front(0, {});
  Launcher launcher(program, front_limits(scene));  // as the one that serves
  launcher.start(std::move(front.its_link), std::move(front.its_log));
  FrontMessage said = next_message(front);
  if (said.kind == FrontMessage::Kind::kHello && said.layout == layout_hash() &&
      front.welcome(pages, bytes, files)) {
    said = next_message(front);
  }
  if (said.kind == FrontMessage::Kind::kReady) return said.text.str();
  const bool refused = said.kind == FrontMessage::Kind::kCannotServe;
  throw core::TransportError(refused ? said.text.str() : program.string() + " is of another build");
}

}  // namespace haptic::server
