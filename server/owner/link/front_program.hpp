#pragma once
/// hapticd-front as a process of its own, and where its program lies.

#include <filesystem>
#include <string>
#include <vector>

#include "server/owner/app.hpp"
#include "server/owner/link/launcher.hpp"

namespace haptic::server {

/// $HAPTICD_FRONT; else hapticd-front in the folder of this program; else in ../libexec/hapticd
/// below that. Throws TransportError if it is none that can be run.
[[nodiscard]] std::filesystem::path front_program();

/// Limits of every front of this daemon.
[[nodiscard]] FrontLimits front_limits(const Scene& scene);

/// The front as processes that `launcher` starts; null: the scene is offline, and only the local
/// control socket is served. `lost`: as FrontLink::Config.
[[nodiscard]] std::unique_ptr<FrontRunner> front_process(App& app, Launcher* launcher,
                                                         std::function<void()> lost);

/// Has a front check the files of TLS that a scene names, and say what is wrong; the answer is the
/// exit status to leave with.
[[nodiscard]] int check_tls(const std::string& resolved_scene);

}  // namespace haptic::server
