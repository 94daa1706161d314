#pragma once
/// Rights that the front's process gives up before it reads the first byte from the network, so
/// that a hole in a library there cannot reach the device. The launcher has taken rights and memory
/// away before; this takes files and system calls.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace haptic::server {

enum class UsesTls : std::uint8_t { kNo, kYes };

/// For good, for every thread of this process and all that they start. Files: open first what you
/// need, because no file can be opened afterwards. Seccomp allows the calls that serving needs and
/// refuses all others with EPERM: to connect, to make or bind sockets, to signal, trace or start
/// processes, to change scheduling, to share memory, to make memory executable. A call by another
/// ABI of the processor ends the process. `shared` are descriptors of things that the owner has
/// too: their flags and options cannot be changed, nor can they be copied, shut down or watched by
/// an epoll. Landlock denies files, ports, names and signals a second time, if the kernel has it.
/// confine_sockets() must follow. Returns a sentence for each protection that this kernel lacks,
/// with what holds without it; throws core::TransportError if the kernel refused what it can do.
[[nodiscard]] std::vector<std::string> confine(UsesTls uses_tls, std::span<const int> shared = {});
/// The end of it, before the first byte from the network: `sockets` came since then, and are as
/// `shared` from now on. Throws as confine().
void confine_sockets(std::span<const int> sockets);
/// Its part that Landlock does; what this kernel's lacks. No_new_privs must be set, or it throws.
[[nodiscard]] std::string confine_by_landlock();

}  // namespace haptic::server
