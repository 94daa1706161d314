#pragma once
/// A file that a scene names, which the owner opened for this front.

#include <string>

#include "server/base/descriptor.hpp"

namespace haptic::server {

/// The file's content. Throws core::TransportError that begins with `name`: it cannot be read, or
/// has more than 1 MB. `name`: "server.tls.key = '/etc/hapticd/key.pem'".
[[nodiscard]] std::string read_named(const std::string& name, const Descriptor& file);

}  // namespace haptic::server
