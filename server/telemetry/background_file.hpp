#pragma once
/// A file that is written on a thread of its own: whoever appends never waits for the disk.

#include <sys/types.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string_view>

namespace haptic::server {

class BackgroundFile {
 public:
  /// As write(2). For tests.
  using Write = std::function<ssize_t(int file, const void* data, std::size_t size)>;

  /// What may wait for a slow disk: some ten seconds of a finger's rows.
  static constexpr std::size_t kMostWaiting = 8 << 20;

  /// Creates or empties the file. Throws SceneError with the system's reason.
  explicit BackgroundFile(const std::filesystem::path& file, Write write = {});
  /// Writes what waits and closes. A disk that does not take it within a second is left alone with
  /// it.
  ~BackgroundFile();
  BackgroundFile(const BackgroundFile&) = delete;
  BackgroundFile& operator=(const BackgroundFile&) = delete;

  /// False where the text is lost: too much waits already, or the file has ended.
  [[nodiscard]] bool append(std::string_view text);
  /// Writing failed (disk full): the file ends there, with one warning in the log.
  [[nodiscard]] bool ended() const;

 private:
  struct Shared;
  static void serve(const std::shared_ptr<Shared>& shared, const Write& write);

  std::shared_ptr<Shared> shared_;
};

}  // namespace haptic::server
