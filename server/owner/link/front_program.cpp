#include "server/owner/link/front_program.hpp"

#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "haptic/core/error.hpp"
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

class Process final : public FrontRunner {
 public:
  Process(App& app, Launcher* launcher, std::function<void()> lost)
      : link_(app.owner(),
              {launcher, app.scene().resolved, app.scene().name, [&app] { return app.facts(); },
               app.tick_metrics(), app.realtime().facts.sched_fifo, std::move(lost)}) {}
  void start() override { link_.start(); }
  void stop() override { link_.stop(); }
  void before_tick() noexcept override { link_.before_tick(); }
  void restart() override { link_.restart_front(); }
  [[nodiscard]] std::vector<std::string> addresses() const override { return link_.addresses(); }

 private:
  FrontLink link_;
};

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
  return std::make_unique<Process>(app, launcher, std::move(lost));
}

int check_tls(const std::string& resolved_scene) {
  const std::string program = front_program().string();
  const int scene = memfd_create("haptic-scene", 0);  // passed on by exec
  const auto size = static_cast<ssize_t>(resolved_scene.size());
  if (scene < 0 || ::write(scene, resolved_scene.data(), resolved_scene.size()) != size) {
    throw core::TransportError(std::string("memory for the scene: ") + std::strerror(errno));
  }
  std::string option = "--check-tls=/proc/self/fd/" + std::to_string(scene);
  std::string name = "hapticd-front";
  char* const arguments[] = {name.data(), option.data(), nullptr};
  pid_t pid = 0;
  const int error = posix_spawn(&pid, program.c_str(), nullptr, nullptr, arguments, environ);
  close(scene);
  if (error != 0) throw core::TransportError(program + ": " + std::strerror(error));
  int status = 0;
  waitpid(pid, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace haptic::server
