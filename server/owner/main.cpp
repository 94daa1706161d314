/// hapticd: reads the command line and a scene, serves until SIGTERM, SIGINT or SIGHUP.
/// Exit status: 0 served and stopped, 1 could not serve, 2 bad command line or scene.

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <map>
#include <mutex>
#include <optional>
#include <sstream>
#include <stop_token>
#include <thread>

#include "haptic/core/error.hpp"
#include "haptic/wire/printable.hpp"
#include "hw/device_config.hpp"
#include "server/base/log.hpp"
#include "server/base/start_limits.hpp"
#include "server/base/thread_setup.hpp"
#include "server/base/version.hpp"
#include "server/owner/app.hpp"
#include "server/owner/link/front_program.hpp"
#include "server/owner/link/listeners.hpp"
#include "server/owner/scene/shipped.hpp"
#include "server/owner/telemetry/new_file.hpp"
#include "server/owner/telemetry/service_manager.hpp"

namespace {

using haptic::server::LogFormat;
using haptic::server::RealtimeMode;

struct CommandLine {
  std::string scene{};
  std::vector<std::string> set{};
  std::vector<std::string> listen{};
  haptic::server::AppOptions options{};
  bool print_scene{false};
  bool check_scene{false};
};

/// Checks what a scene's text cannot show: that the files it names can be read, and its recording
/// written. To open a device that is not hardware reads its files and moves nothing; a check
/// does not touch hardware.
void check_files(const haptic::server::Scene& scene) {
  for (const haptic::server::DeviceScene& device : scene.devices) {
    if (device.source->is_hardware()) continue;
    const auto opened = device.source->open(device.pipeline.kinematics, {});
    for (const std::string& note : opened->info().notes) {
      std::cerr << "warning: " << haptic::wire::printable(device.name + ": " + note) << "\n";
    }
  }
  if (!scene.record) return;
  for (std::size_t i = 0; i < scene.devices.size(); ++i) {
    haptic::server::check_creatable(record_file(scene, i), scene.record->overwrite);
  }
}

/// While the scene is read a signal ends hapticd at once, with status 0 as later: nothing is open.
/// A file at the limit of its size (SIGXFSZ), and memory for a front counts as one, is an error.
void end_at_once_by_signals() {
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) std::signal(number, [](int) { _exit(0); });
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

/// Blocks the signals in every thread, because threads inherit the block; main takes them by
/// sigwait(). A second signal stays pending while hapticd stops, and does not cut the stop short.
sigset_t block_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) std::signal(number, SIG_DFL);
  return signals;
}

/// While devices open and the first front binds, signals wait. If one has waited for 2 s this ends
/// hapticd, with status 0 as otherwise: before the loop begins no device is armed.
class EndOfALongStart {
 public:
  explicit EndOfALongStart(const sigset_t& signals)
      : thread_([signals](const std::stop_token& started) { watch(signals, started); }) {}

 private:
  static void watch(const sigset_t& signals, const std::stop_token& started) {
    haptic::server::set_thread_up("start");
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any wakes;
    for (int waited = 0; waited < 20;) {
      wakes.wait_for(lock, started, std::chrono::milliseconds(100), [] { return false; });
      if (started.stop_requested()) return;
      sigset_t pending, of_these;
      sigpending(&pending);
      sigandset(&of_these, &pending, &signals);
      if (sigisemptyset(&of_these) == 0) ++waited;
    }
    std::cerr << "hapticd: ended before it served\n";
    _exit(0);
  }

  std::jthread thread_;
};

/// Ends this process, with status 1, if it has not ended by then: a front, its launcher or a file
/// must not hold a stop up. Force is gone and devices are disarmed long before.
void end_within(std::chrono::milliseconds most) {
  std::thread([most] {
    haptic::server::set_thread_up("end");
    std::this_thread::sleep_for(most);
    spdlog::error("a part of hapticd does not end: it is left");
    haptic::server::finish_log();
    _exit(1);
  }).detach();
}

/// Opens /dev/null for each standard stream that is closed; otherwise the next file that is opened,
/// such as a serial port, would get the number of the log and receive its lines.
void hold_standard_streams() {
  int number = 0;
  do {
    number = open("/dev/null", O_RDWR);
  } while (number >= 0 && number <= STDERR_FILENO);
  if (number > STDERR_FILENO) close(number);
}

/// Waits for a signal that ends hapticd, and meanwhile tells the service manager that the loop
/// ticks.
int wait_for_end(const sigset_t& signals, haptic::server::App& app,
                 haptic::server::ServiceManager& manager) {
  const auto period = manager.pulse_period().value_or(std::chrono::hours(1));
  const auto seconds = std::chrono::floor<std::chrono::seconds>(period);
  const timespec at_most{seconds.count(), static_cast<long>((period - seconds).count())};
  for (;;) {
    manager.pulse(app.loop_facts().ticks);
    const int signal = sigtimedwait(&signals, nullptr, &at_most);
    if (signal <= 0) continue;
    if (signal != SIGHUP || !manager.present()) return signal;
    spdlog::info("SIGHUP: a new front, which reads the certificates again");
    app.restart_front();
  }
}

int serve(haptic::server::Scene scene, const CommandLine& line, const sigset_t& signals) {
  // Forked while this thread is the only one: the log has one too.
  std::optional<haptic::server::Launcher> launcher;
  if (!scene.server.offline) {
    if (!line.listen.empty()) scene.server.listen = line.listen;
    // An address that is taken is said before a device is opened.
    static_cast<void>(haptic::server::Listeners(scene.server, line.options.insecure_lab));
    launcher.emplace(haptic::server::front_program(), haptic::server::front_limits(scene));
  }
  if (getpid() == 1) std::signal(SIGCHLD, SIG_IGN);  // in a container: it reaps what others leave
  haptic::server::log_to_stderr(line.options.log_format == "json" ? LogFormat::kJson
                                                                  : LogFormat::kText);
  spdlog::set_level(spdlog::level::from_str(line.options.log_level));
  const std::vector<std::string> warnings = scene.warnings;
  std::atomic<bool> front_lost{false};
  haptic::server::App app(std::move(scene), line.options, [&](haptic::server::App& owner) {
    return haptic::server::front_process(owner, launcher ? &*launcher : nullptr, [&] {
      spdlog::error("the launcher of the front is gone: hapticd stops");
      front_lost.store(true);
      kill(getpid(), SIGTERM);
    });
  });
  {
    const EndOfALongStart watch(signals);
    app.start();
  }
  for (const std::string& warning : warnings) spdlog::warn(warning);
  auto manager = haptic::server::ServiceManager::of_environment();
  manager.ready(app.realtime().facts.grade.str() + ": " + app.realtime().facts.explanation.str());
  const int signal = wait_for_end(signals, app, manager);
  end_within(std::chrono::milliseconds(4500));
  manager.stopping();
  spdlog::info("SIG{}: force fades out, devices are disarmed", sigabbrev_np(signal));
  app.stop();
  spdlog::info("stopped");
  return front_lost.load() ? 1 : 0;
}

/// A file, or the name of a scene that comes with hapticd.
std::filesystem::path scene_file(const std::string& given) {
  if (std::filesystem::exists(given)) return given;
  if (const auto shipped = haptic::server::find_scene(given)) return *shipped;
  const std::string like = haptic::server::scene_like(std::filesystem::path(given).stem());
  if (like.empty()) return given;
  throw haptic::core::SceneError(given + ": no such file or scene; did you mean " + like + "?");
}

/// The scenes that come with hapticd, a line each; empty if there are none.
std::string shipped_scenes() {
  std::string text;
  for (const auto& [name, summary] : haptic::server::shipped_scenes()) {
    text +=
        "  " + name + std::string(name.size() < 26 ? 26 - name.size() : 1, ' ') + summary + "\n";
  }
  return text;
}

/// Prints why hapticd does not serve; to the journal with the priority of an error.
int refuse(const std::string& why, int status) {
  const char* const priority = haptic::server::stderr_is_journal() ? "<3>" : "";
  std::istringstream lines("hapticd: " + why);
  for (std::string line; std::getline(lines, line);) {
    std::cerr << priority << haptic::wire::printable(line) << "\n";
  }
  return status;
}

int run(const CommandLine& line) {
  try {
    end_at_once_by_signals();
    haptic::server::Scene scene = haptic::server::load_scene(scene_file(line.scene), line.set);
    if (line.print_scene) std::cout << scene.resolved;
    if (line.check_scene) {
      check_files(scene);
      for (const std::string& warning : scene.warnings) std::cerr << "warning: " << warning << "\n";
      std::istringstream told(haptic::server::check_front_files(scene));
      for (std::string one; std::getline(told, one);) {
        std::cerr << "warning: " << haptic::wire::printable(one) << "\n";
      }
      std::cout << line.scene << ": ok\n";
    }
    if (line.print_scene || line.check_scene) return 0;
    return serve(std::move(scene), line, block_signals());
  } catch (const haptic::core::SceneError& error) {
    return refuse(error.what(), 2);
  } catch (const std::exception& error) {
    return refuse(error.what(), 1);
  }
}

/// Nothing: serve; else the exit status to leave with.
std::optional<int> parse(int argc, char** argv, CommandLine& line) {
  const std::map<std::string, RealtimeMode> modes{{"require", RealtimeMode::kRequire},
                                                  {"try", RealtimeMode::kTry},
                                                  {"off", RealtimeMode::kOff}};
  CLI::App cli("hapticd - networked haptic server for underactuated devices", "hapticd");
  cli.set_version_flag("--version", std::string("hapticd ") + haptic::server::version());
  cli.footer("Exit status: 0 served and stopped, 1 could not serve, 2 bad command line or scene.");
  cli.add_option("--scene", line.scene,
                 "scene to serve: a file (textproto), or the name of one that comes with hapticd");
  cli.add_option("--set", line.set, "PATH=VALUE: overrides a field of the scene; may be repeated")
      ->take_all();
  cli.add_option("--listen", line.listen,
                 "host:port or unix:/path instead of the scene's addresses; may be repeated")
      ->check(CLI::Validator(haptic::server::address_problem, ""));
  cli.add_option_function<std::string>(
         "--realtime", [&](const std::string& mode) { line.options.realtime = modes.at(mode); },
         "require, try or off (default try)")
      ->check(CLI::IsMember({"require", "try", "off"}));
  cli.add_option("--log-level", line.options.log_level, "debug, info, warn or error (default info)")
      ->check(CLI::IsMember({"debug", "info", "warn", "error"}));
  cli.add_option("--log-format", line.options.log_format,
                 "text or json, a line per message (default text)")
      ->check(CLI::IsMember({"text", "json"}));
  cli.add_flag("--insecure-lab", line.options.insecure_lab,
               "plain text on addresses beyond this host: for a network that is yours alone");
  cli.add_flag("--print-scene", line.print_scene, "print the scene with every default, and exit");
  cli.add_flag("--check-scene", line.check_scene, "check the scene, and exit");
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return cli.exit(error) == 0 ? 0 : 2;
  }
  if (!line.scene.empty()) return std::nullopt;
  return refuse("--scene is missing: give a file, or one of the scenes that come with hapticd\n" +
                    shipped_scenes() + "hapticd --help lists every option",
                2);
}

}  // namespace

int main(int argc, char** argv) {
  hold_standard_streams();
  CommandLine line;
  try {
    haptic::server::check_memory_limits();
    if (const auto status = parse(argc, argv, line)) return *status;
    haptic::server::check_start_limits();
  } catch (const std::exception& error) {
    return refuse(error.what(), 1);
  }
  const int status = run(line);
  haptic::server::finish_log();
  return status;
}
