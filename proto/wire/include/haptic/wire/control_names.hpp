#pragma once
/// Names of a hapticd's local control socket (server/README.md#the-local-control-socket), for the
/// server that binds it and for hapticctl, which looks for it: one for each address that it serves.

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace haptic::wire {

/// The folder of root's hapticd, and of the service's. Other users' have kControlSubfolder of their
/// runtime folder ($XDG_RUNTIME_DIR).
inline constexpr const char* kControlFolder = "/run/hapticd";
inline constexpr const char* kControlSubfolder = "/hapticd";
/// Ends the file's name of the socket that every user may ask; the one without it is for hapticd's
/// user and root alone.
inline constexpr const char* kForAll = ".all";
/// The fallback lies in the abstract namespace, which has no rights: this and control_file().
inline constexpr const char* kAbstractPrefix = "hapticd/";

/// The name as a file's: itself, if it is short and has letters, digits and . : _ - % [ ] alone;
/// else 16 digits made of all of it, so that two long names stay two.
[[nodiscard]] inline std::string control_file(std::string_view name) {
  constexpr std::size_t kLongest = 48;
  const bool plain = std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view(".:_-%[]").find(c) != std::string_view::npos;
  });
  if (plain && !name.empty() && name.front() != '.' && name.size() <= kLongest) {
    return std::string(name);
  }
  std::uint64_t hash = 14695981039346656037ULL;  // FNV-1a
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  char digits[20];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(hash));
  return digits;
}

/// "127.0.0.1:PORT", "[::1]:PORT"; an IPv4 address that is written as one of IPv6 is one of IPv4.
[[nodiscard]] inline std::string endpoint_name(const sockaddr& address) {
  sockaddr_in v4{};
  const sockaddr* named = &address;
  socklen_t size = address.sa_family == AF_INET6 ? sizeof(sockaddr_in6) : sizeof(sockaddr_in);
  const auto& v6 = reinterpret_cast<const sockaddr_in6&>(address);
  if (address.sa_family == AF_INET6 && IN6_IS_ADDR_V4MAPPED(&v6.sin6_addr)) {
    v4.sin_family = AF_INET;
    v4.sin_port = v6.sin6_port;
    std::copy_n(v6.sin6_addr.s6_addr + 12, 4, reinterpret_cast<unsigned char*>(&v4.sin_addr));
    named = reinterpret_cast<const sockaddr*>(&v4);
    size = sizeof v4;
  }
  char host[NI_MAXHOST], port[NI_MAXSERV];
  if (getnameinfo(named, size, host, sizeof host, port, sizeof port,
                  NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
    return {};
  }
  const bool brackets = named->sa_family == AF_INET6;
  return (brackets ? "[" : "") + std::string(host) + (brackets ? "]:" : ":") + port;
}

struct FreeAddresses {
  void operator()(addrinfo* list) const noexcept { freeaddrinfo(list); }
};
/// The TCP addresses that "host:port" stands for; null: none.
[[nodiscard]] inline std::unique_ptr<addrinfo, FreeAddresses> resolved(const std::string& address) {
  const std::size_t colon = std::min(address.rfind(':'), address.size());
  std::string host = address.substr(0, colon);
  if (host.size() > 2 && host.front() == '[') host = host.substr(1, host.size() - 2);
  const std::string port = address.substr(std::min(colon + 1, address.size()));
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* first = nullptr;
  if (host.empty() || getaddrinfo(host.c_str(), port.c_str(), &hints, &first) != 0) return {};
  return std::unique_ptr<addrinfo, FreeAddresses>(first);
}

/// Names of the socket of a server at "unix:/path", "unix:///path" or "host:port". A UNIX socket
/// has two: of its file, whatever path leads there, and of its path, if the file is gone.
[[nodiscard]] inline std::vector<std::string> control_names(const std::string& address) {
  constexpr std::string_view kUnix = "unix:";
  std::vector<std::string> names;
  if (address.starts_with(kUnix)) {
    std::string path = address.substr(kUnix.size());
    if (path.starts_with("//")) path.erase(0, 2);
    struct stat file {};
    if (stat(path.c_str(), &file) == 0) {
      names.push_back("file:" + std::to_string(file.st_dev) + ":" + std::to_string(file.st_ino));
    }
    std::error_code error;
    names.push_back("unix:" + std::filesystem::weakly_canonical(path, error).string());
    return names;
  }
  const auto all = resolved(address);
  for (const addrinfo* each = all.get(); each != nullptr; each = each->ai_next) {
    names.push_back(endpoint_name(*each->ai_addr));
  }
  if (names.empty()) names.push_back(address);
  return names;
}

}  // namespace haptic::wire
