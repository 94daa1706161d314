#pragma once
/// Hand-over from the owner to every front of this daemon: a configuration and sockets, which stay
/// the same, and files, which are opened for each front again.

#include <filesystem>
#include <string>
#include <vector>

#include "server/crossing/front_config.hpp"
#include "server/crossing/ports.hpp"
#include "server/crossing/shared_memory.hpp"
#include "server/owner/link/listeners.hpp"

namespace haptic::server {

/// The configuration that a scene says, without its addresses and devices.
[[nodiscard]] FrontConfig front_config(const ServerScene& scene, bool insecure_lab);
/// FrontStart::files. Throws core::TransportError with the field and the file: it cannot be read,
/// is no plain file, has more than 1 MB; or, if it holds a secret, belongs neither to root nor to
/// this process's user, or other users may read or change it. A symbolic link is followed once.
[[nodiscard]] std::vector<Descriptor> open_files(const FrontConfig& config,
                                                 const std::filesystem::path& page);
/// Where the page of the front at `program` lies: "page/dist" next to it as it was built, or
/// "share/haptic/page" of the prefix that it was installed in.
[[nodiscard]] std::filesystem::path page_folder(const std::filesystem::path& program);

/// The bytes of `config`, in memory that a front can only read. Throws core::TransportError if they
/// are more than kLargestConfig, or if no front can be given its descriptors.
[[nodiscard]] SharedMemory to_memory(const FrontConfig& config);

class HandOver {
 public:
  /// Binds the addresses of `scene` for `config`, whose addresses it sets. Throws
  /// core::TransportError. `page`: page_folder().
  HandOver(FrontConfig config, const ServerScene& scene, std::filesystem::path page);

  [[nodiscard]] const FrontConfig& config() const noexcept { return config_; }
  [[nodiscard]] std::vector<std::string> addresses() const;
  /// For one front. Throws core::TransportError, as open_files().
  [[nodiscard]] std::vector<Descriptor> files() const { return open_files(config_, page_); }
  /// Files and sockets, for a front in this process. Throws as files().
  [[nodiscard]] FrontStart start() const { return {config_, listeners_.sockets(), files()}; }
  /// For one front, when no other one has them.
  [[nodiscard]] Listeners& listeners() noexcept { return listeners_; }

 private:
  Listeners listeners_;
  FrontConfig config_;
  const std::filesystem::path page_;
};

}  // namespace haptic::server
