#include "server/owner/link/hand_over.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "haptic/core/error.hpp"
#include "server/crossing/link_messages.hpp"
#include "server/crossing/packet_socket.hpp"

namespace haptic::server {
namespace {

namespace fs = std::filesystem;

/// Certificates and keys have some KB; a wrong file must not fill the memory.
constexpr off_t kLargestFile = 1 << 20;

enum class Holds : std::uint8_t { kNoSecret, kSecret };

Descriptor open_file(const std::string& field, const fs::path& file, Holds holds) {
  const auto refuse = [&](const std::string& why) {
    return core::TransportError(field + " = '" + file.string() + "': " + why);
  };
  std::error_code ignored;
  const fs::path real = fs::canonical(file, ignored);
  // Without O_NONBLOCK the opening of a pipe waits for its writer.
  Descriptor opened(open(real.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  struct stat status {};
  if (!opened || fstat(opened.get(), &status) != 0) {
    throw refuse(std::string("cannot be read: ") + std::strerror(errno));
  }
  if (!S_ISREG(status.st_mode)) throw refuse("must be a plain file");
  if (status.st_size > kLargestFile) throw refuse("has more than 1 MB");
  if (holds == Holds::kNoSecret) return opened;
  if (status.st_uid != 0 && status.st_uid != geteuid()) {
    throw refuse("belongs to user " + std::to_string(status.st_uid) +
                 ": must belong to root or to the user of hapticd, " + std::to_string(geteuid()));
  }
  // Its group may read it, as Debian's ssl-cert does.
  if ((status.st_mode & (S_IROTH | S_IWOTH | S_IWGRP)) != 0) {
    throw refuse("other users may read or change it: chmod 600, or 640 for a group");
  }
  return opened;
}

}  // namespace

FrontConfig front_config(const ServerScene& scene, bool insecure_lab) {
  FrontConfig config;
  config.max_sessions = scene.max_sessions;
  config.tls = scene.tls;
  config.web = scene.web;
  config.insecure_lab = insecure_lab;
  return config;
}

std::vector<Descriptor> open_files(const FrontConfig& config, const fs::path& page) {
  std::vector<Descriptor> files;
  if (config.tls) {
    const TlsConfig& tls = *config.tls;
    files.push_back(open_file("server.tls.certificate", tls.certificate, Holds::kNoSecret));
    files.push_back(open_file("server.tls.key", tls.key, Holds::kSecret));
    if (!tls.client_ca.empty()) {
      files.push_back(open_file("server.tls.client_ca", tls.client_ca, Holds::kNoSecret));
    }
  }
  if (!config.web) return files;
  for (const WebToken& token : config.web->tokens) {
    files.push_back(
        open_file("server.web.token '" + token.name + "': file", token.file, Holds::kSecret));
  }
  files.emplace_back(open(page.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  if (!files.back()) files.back() = Descriptor(open("/dev/null", O_RDONLY | O_CLOEXEC));
  return files;
}

fs::path page_folder(const fs::path& program) {
  std::error_code ignored;
  const fs::path folder = fs::weakly_canonical(program, ignored).parent_path();
  if (fs::path built = folder / "page" / "dist"; fs::is_directory(built)) return built;
  // PREFIX/libexec/hapticd/hapticd-front, or PREFIX/bin/hapticd-front.
  const bool libexec = folder.parent_path().filename() == "libexec";
  const fs::path prefix = libexec ? folder.parent_path().parent_path() : folder.parent_path();
  return prefix / "share" / "haptic" / "page";
}

SharedMemory to_memory(const FrontConfig& config) {
  const std::string bytes = to_bytes(config);
  if (bytes.size() > kLargestConfig) {
    throw core::TransportError("the devices' descriptions have " + std::to_string(bytes.size()) +
                               " bytes: at most " + std::to_string(kLargestConfig) +
                               " go to a front");
  }
  const std::size_t descriptors =
      OwnerMessage::kDescriptors + sockets_of(config) + files_of(config);
  if (descriptors > kMostDescriptors) {
    throw core::TransportError("the scene's addresses and files are " +
                               std::to_string(descriptors) + " descriptors: at most " +
                               std::to_string(kMostDescriptors) + " go to a front");
  }
  SharedMemory memory("haptic-config", bytes.size());
  std::memcpy(memory.data(), bytes.data(), bytes.size());
  return memory;
}

HandOver::HandOver(FrontConfig config, const ServerScene& scene, fs::path page)
    : listeners_(scene, config.insecure_lab), config_(std::move(config)), page_(std::move(page)) {
  config_.addresses = listeners_.addresses();
  config_.udp_listen = listeners_.udp_listen();
}

std::vector<std::string> HandOver::addresses() const {
  std::vector<std::string> all;
  for (const FrontConfig::Address& address : config_.addresses) all.push_back(address.name);
  return all;
}

}  // namespace haptic::server
