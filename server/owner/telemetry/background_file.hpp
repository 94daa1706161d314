#pragma once
/// A file of lines that is written on a thread of its own: the caller never waits for the disk.

#include <sys/types.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string_view>

#include "server/owner/telemetry/new_file.hpp"

namespace haptic::server {

class BackgroundFile {
 public:
  /// The type of write(2), for tests.
  using Write = std::function<ssize_t(int file, const void* data, std::size_t size)>;

  /// Bytes that may wait for a slow disk: some ten seconds of a finger's rows.
  static constexpr std::size_t kMostWaiting = 8 << 20;

  /// Takes the descriptor over, and closes it in the end. `realtime`: the thread does not wait for
  /// ordinary programs, so that no more memory is needed next to many that compute.
  explicit BackgroundFile(const NewFile& file, bool realtime = false, Write write = {});
  /// Writes what waits and closes. A disk that does not take it within a second is left alone with
  /// it.
  ~BackgroundFile();
  BackgroundFile(const BackgroundFile&) = delete;
  BackgroundFile& operator=(const BackgroundFile&) = delete;

  /// Appends whole lines. They are on their way to the file after a quarter of a second at the
  /// latest: that is what a killed server loses. False if they are lost: too much waits already, or
  /// the file has ended.
  [[nodiscard]] bool append(std::string_view lines);
  /// Writing failed (disk full, limit on the file's size): the file ends there at a whole line,
  /// with one warning in the log.
  [[nodiscard]] bool ended() const;
  [[nodiscard]] const std::filesystem::path& path() const noexcept;

 private:
  struct Shared;
  static void serve(const std::shared_ptr<Shared>& shared, const Write& write);

  std::shared_ptr<Shared> shared_;
};

}  // namespace haptic::server
