/// hapticd-front: what faces the network. hapticd starts it, with a socket as descriptor 3.
/// Exit status: 0 told to leave; 1 could not serve; 2 not started by hapticd.

#include <fcntl.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <csignal>
#include <iostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/base/log.hpp"
#include "server/base/process.hpp"
#include "server/base/version.hpp"
#include "server/front/confinement.hpp"
#include "server/front/server.hpp"
#include "server/front/session/owner_link.hpp"

#if defined(__SANITIZE_ADDRESS__)
// The leak checker traces its own process, which a confined one may not.
extern "C" int __lsan_is_turned_off() {  // NOLINT(bugprone-reserved-identifier): its name
  return 1;
}
#endif

namespace {

using namespace haptic::server;

constexpr int kLink = 3;
constexpr haptic::core::Duration kCallsGrace = std::chrono::seconds(1);

/// Has a thread.
void begin_log(const FrontConfig& config) {
  log_to_stderr(LogFormat::kBare);
  spdlog::set_level(spdlog::level::from_str(config.log_level));
}

/// All that is open but the files: those are read and closed here, and their numbers used again.
std::vector<int> shared_with_owner(const FrontStart& start) {
  constexpr int kAbove = 512;  // more than one message can bring
  std::vector<int> shared;
  for (int fd = 0; fd < kAbove; ++fd) {
    const bool file = std::any_of(start.files.begin(), start.files.end(),
                                  [fd](const Descriptor& each) { return each.get() == fd; });
    if (!file && fcntl(fd, F_GETFD) >= 0) shared.push_back(fd);
  }
  return shared;
}

/// Until the owner wants no front any more; throws what keeps it from serving.
void serve(OwnerLink& owner) {
  FrontStart start = owner.hello();
  Page page;
  std::string warnings;
  if (start.config.web) {
    // The descriptor leads to it: hapticd's user may reach the folder, and this process not.
    try {
      page = load_page("/proc/self/fd/" + std::to_string(start.files.back().get()));
    } catch (const std::exception& error) {
      warnings = std::string(error.what()) + ": browsers get no page";
    }
  }
  const UsesTls uses_tls = start.config.tls ? UsesTls::kYes : UsesTls::kNo;
  const std::vector<std::string> missing = confine(uses_tls, shared_with_owner(start));
  begin_log(start.config);
  for (const std::string& sentence : missing) {
    spdlog::info("confinement of the front: {}", sentence);
  }
  if (!warnings.empty()) spdlog::warn(warnings);
  FrontServer server(
      std::move(start), owner,
      {[&owner] { return owner.facts(); },
       [&owner](std::size_t device) { return owner.totals(device); },
       [&owner](const FrontCounters& own) { return owner.count(own); }, std::move(page)});
  for (const std::string& one : server.warnings()) warnings += (warnings.empty() ? "" : "\n") + one;
  owner.say({.kind = FrontMessage::Kind::kReady, .text = warnings});
  auto sockets = owner.wait_for_go();
  if (!sockets) return;
  std::vector<int> numbers;
  for (const Descriptor& each : *sockets) numbers.push_back(each.get());
  server.take(std::move(*sockets));
  confine_sockets(numbers);
  forget_the_start();
  owner.begin();
  server.start();
  owner.say({.kind = FrontMessage::Kind::kServing});
  owner.wait_for_leave();
  server.stop(kCallsGrace);
  owner.stop();
}

}  // namespace

int main(int argc, char** argv) {
  // Ctrl-C in a terminal reaches every process of it; hapticd ends its front by itself.
  for (const int ignored : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(ignored, SIG_IGN);
  if (argc == 2 && std::string_view(argv[1]) == "--version") {
    std::cout << "hapticd-front " << version() << "\n";
    return 0;
  }
  if (fcntl(kLink, F_GETFD) < 0) {
    std::cerr << "hapticd-front: faces the network for hapticd, which starts it\n";
    return 2;
  }
  OwnerLink owner{Descriptor(kLink)};
  int status = 0;
  try {
    serve(owner);
  } catch (const std::exception& error) {
    owner.say({.kind = FrontMessage::Kind::kCannotServe, .text = std::string_view(error.what())});
    status = 1;
  }
  finish_log();
  return status;
}
