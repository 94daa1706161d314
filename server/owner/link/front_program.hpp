#pragma once
/// hapticd-front as a process of its own, and where its program lies.

#include <filesystem>

#include "server/owner/app.hpp"
#include "server/owner/link/hand_over.hpp"
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

/// The configuration of the fronts of `app`, whose devices are open.
[[nodiscard]] FrontConfig front_config(const App& app);

/// Has a confined front check the files that a scene names for it: those of TLS and of tokens. The
/// answer: its warnings, a line each. Throws core::TransportError that says what is wrong.
[[nodiscard]] std::string check_front_files(const Scene& scene);

}  // namespace haptic::server
