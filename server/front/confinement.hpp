#pragma once
/// Rights that the front's process gives up before it reads the first byte from the network, so
/// that a hole in a library there cannot reach the device. The launcher has taken rights and memory
/// away before; this takes files and system calls.

#include <filesystem>
#include <string>
#include <vector>

namespace haptic::server {

struct ConfinedFiles {
  std::vector<std::filesystem::path> read{};     ///< files and folders
  std::vector<std::filesystem::path> sockets{};  ///< folders in which it may bind UNIX sockets
};

/// For good, for this thread and all that it starts: call it before the first thread. Landlock
/// denies every file but these and the system's libraries and name services; seccomp denies to
/// signal, trace or read another process, to start a program, to change scheduling, to mount, and
/// to make descriptors of devices and other processes. Returns what the kernel could not do, a
/// sentence each; throws core::TransportError if it refused what it can do.
[[nodiscard]] std::vector<std::string> confine(const ConfinedFiles& files);

}  // namespace haptic::server
