#pragma once
/// The control socket of a hapticd on this host: the way to stop it that needs no network and no
/// front (server/README.md#the-local-control-socket).

#include <optional>
#include <string>
#include <vector>

namespace haptic::ctl {

/// The lines after "ok" of the answer to one command, such as "stop finger", by the hapticd that
/// serves at `server`: any address that the client library takes and that leads to this host, or
/// "local:SCENE" for a hapticd without a network. Absent: there is no such socket on this host, it
/// gave no answer within `patience_ms`, it is not root's, this user's or the service's (which is
/// printed), or it refused; `refusal` then says why, if it did.
[[nodiscard]] std::optional<std::vector<std::string>> ask_locally(const std::string& server,
                                                                  const std::string& command,
                                                                  std::string* refusal = nullptr,
                                                                  int patience_ms = 2'000);

/// Names that the socket of a hapticd at `server` may have (haptic::wire::control_names): it may
/// listen on all addresses of this host, or be known by another word.
[[nodiscard]] std::vector<std::string> control_names_of(std::string server);

}  // namespace haptic::ctl
