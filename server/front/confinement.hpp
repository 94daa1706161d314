#pragma once
/// Rights that the front's process gives up before it reads the first byte from the network, so
/// that a hole in a library there cannot reach the device. The launcher has taken rights and memory
/// away before; this takes files and system calls.

#include <string>
#include <vector>

namespace haptic::server {

/// For good, for this thread and all that it starts: call it before the first thread. Landlock
/// denies every file but the system's libraries and name services, what is open already, and what
/// lies in `folder` if that is the descriptor of one; seccomp denies to
/// signal, trace or read another process, to start a program, to change scheduling, to mount, and
/// to make descriptors of devices and other processes. Returns what the kernel could not do, a
/// sentence each; throws core::TransportError if it refused what it can do.
[[nodiscard]] std::vector<std::string> confine(int folder = -1);

}  // namespace haptic::server
