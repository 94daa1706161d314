#include "tests/relay/daemon.hpp"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <fstream>
#include <stdexcept>
#include <thread>
#include <utility>

namespace haptic::test {
namespace {

/// `call` (bind or connect) succeeds on a new socket.
template <typename Call>
bool succeeds(Call call, const char* host, int type, std::uint16_t port) {
  const int probe = ::socket(AF_INET, type | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  ::inet_pton(AF_INET, host, &address.sin_addr);
  const bool success =
      call(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(probe);
  return success;
}

bool is_free(const char* host, int type, std::uint16_t port) {
  return succeeds(::bind, host, type, port);
}

/// A gRPC client that finds no listener waits 5 s before it tries again, so the daemon waits first.
void wait_for_listener(std::uint16_t port) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (std::chrono::steady_clock::now() < end) {
    if (succeeds(::connect, "127.0.0.1", SOCK_STREAM, port)) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

/// Below the ports that the kernel gives out by itself.
std::uint16_t free_port(int type) {
  static std::atomic<unsigned> next{static_cast<unsigned>(getpid()) * 37U};
  for (int i = 0; i < 2000; ++i) {
    const auto port = static_cast<std::uint16_t>(12'000 + next++ % 18'000);
    if (is_free("127.0.0.1", type, port) && is_free("127.0.0.2", type, port)) return port;
  }
  throw std::runtime_error("no free port on 127.0.0.1 and 127.0.0.2");
}

/// A late tick is no fault here, so that a busy host does not end the run; it is counted instead.
std::string scene(std::uint16_t udp_port, std::uint16_t web_port,
                  const std::filesystem::path& folder) {
  const auto number = [](auto value) { return std::to_string(value); };
  return R"(name: "a finger behind a relay"
loop { loop_late_fault { seconds: 5 } late_bucket_full: 1000000 }
server { udp_listen: "127.0.0.1:)" +
         number(udp_port) + R"("
  web { listen: "127.0.0.1:)" +
         number(web_port) + R"(" name: "127.0.0.2" token { name: "client" file: ")" +
         (folder / "token").string() + R"(" rights: "primary" } } }
record { file: ")" +
         (folder / "record.csv").string() + R"(" }
device {
  name: "finger"
  simulated_finger { target_mcp_rad: )" +
         number(Daemon::kTarget) + " target_pip_rad: " + number(Daemon::kTarget) + R"( }
  finger_exoskeleton {}
  direction_guard {}
  impedance { stiffness_n_per_m: 1500 damping_n_s_per_m: 0.5 }
  limits { force_n: )" +
         number(Daemon::kForceLimit) + " slew_n_per_s: " + number(Daemon::kSlew) + R"( }
  passivity { tank { initial_j: )" +
         number(Daemon::kTank) + " capacity_j: " + number(Daemon::kTank) + " } } }\n";
}

}  // namespace

Daemon::Daemon(std::vector<std::string> arguments)
    : tcp_port_(free_port(SOCK_STREAM)),
      udp_port_(free_port(SOCK_DGRAM)),
      web_port_(free_port(SOCK_STREAM)) {
  record_ = folder_.path() / "record.csv";
  const auto token = folder_.path() / "token", file = folder_.path() / "scene.textproto";
  std::ofstream(token) << kToken;
  std::filesystem::permissions(token, std::filesystem::perms::owner_read);
  std::ofstream(file) << scene(udp_port_, web_port_, folder_.path());
  arguments.insert(arguments.begin(), {"--scene", file.string()});
  start(std::move(arguments));
}

Daemon::Daemon(const std::string& shipped_scene)
    : tcp_port_(free_port(SOCK_STREAM)), udp_port_(free_port(SOCK_DGRAM)) {
  record_ = folder_.path() / "record.csv";
  start({"--scene", HAPTIC_SOURCE_DIR "/server/scenes/" + shipped_scene + ".textproto", "--set",
         "server.udp_listen=\"127.0.0.1:" + std::to_string(udp_port_) + "\"", "--set",
         "record.file=\"" + record_.string() + "\"", "--set", "loop.loop_late_fault.seconds=5",
         "--set", "loop.late_bucket_full=1000000"});
}

void Daemon::start(std::vector<std::string> scene) {
  scene.insert(scene.end(), {"--listen", address(), "--log-level", "warn"});
  process_ = std::make_unique<Process>(std::string(HAPTIC_BINARY_DIR) + "/server/hapticd", scene);
  wait_for_listener(tcp_port_);
  if (web_port_ != 0) wait_for_listener(web_port_);
}

int Daemon::stop() {
  process_->signal(SIGTERM);
  return process_->wait();
}

}  // namespace haptic::test
