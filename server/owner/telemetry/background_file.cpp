#include "server/owner/telemetry/background_file.hpp"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "server/base/thread_setup.hpp"

namespace haptic::server {
namespace {

/// About a quarter of a second of a finger's rows.
constexpr std::size_t kWorthWriting = 128 * 1024;
constexpr std::chrono::milliseconds kLongestWait{250};
constexpr std::chrono::seconds kLastPatience{1};

/// Removes the beginning of a line from the end of `written`, which stands at the file's end.
void cut_to_whole_line(int file, std::string_view written) {
  const std::size_t newline = written.rfind('\n');
  const std::size_t whole = newline == std::string_view::npos ? 0 : newline + 1;
  if (whole == written.size()) return;
  const off_t end = ::lseek(file, 0, SEEK_CUR);
  if (::ftruncate(file, end - static_cast<off_t>(written.size() - whole)) != 0) {
    spdlog::warn("the last line of a recording is not whole: {}", std::strerror(errno));
  }
}

/// All of `lines`; 0 or the error, and then the file ends at a whole line.
int write_all(const BackgroundFile::Write& write, int file, std::string_view lines) {
  std::size_t written = 0;
  while (written < lines.size()) {
    const ssize_t done = write(file, lines.data() + written, lines.size() - written);
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) {
      const int error = done < 0 ? errno : ENOSPC;
      cut_to_whole_line(file, lines.substr(0, written));
      return error;
    }
    written += static_cast<std::size_t>(done);
  }
  return 0;
}

}  // namespace

/// Outlives the BackgroundFile where the disk hangs: then only the thread holds it.
struct BackgroundFile::Shared {
  explicit Shared(const NewFile& opened) : path(opened.path), file(opened.descriptor) {}
  ~Shared() { ::close(file); }
  Shared(const Shared&) = delete;
  Shared& operator=(const Shared&) = delete;

  const std::filesystem::path path;
  const int file;
  std::mutex mutex;
  std::condition_variable changed;
  std::string waiting;
  bool closing{false};
  bool ended{false};  ///< writing failed
  bool over{false};   ///< the thread is through
};

BackgroundFile::BackgroundFile(const NewFile& file, bool realtime, Write write)
    : shared_(std::make_shared<Shared>(file)) {
  if (!write) write = ::write;
  std::thread([shared = shared_, realtime, write = std::move(write)] {
    // Blocks SIGXFSZ too: at the limit of the file's size a write fails and nothing is killed.
    set_thread_up("haptic-record", realtime);
    serve(shared, write);
  }).detach();
}

BackgroundFile::~BackgroundFile() {
  std::unique_lock lock(shared_->mutex);
  shared_->closing = true;
  shared_->changed.notify_all();
  if (!shared_->changed.wait_for(lock, kLastPatience, [this] { return shared_->over; })) {
    spdlog::warn("{}: the disk does not take the last {} bytes", shared_->path.string(),
                 shared_->waiting.size());
  }
}

bool BackgroundFile::append(std::string_view lines) {
  const std::lock_guard lock(shared_->mutex);
  if (shared_->ended || shared_->waiting.size() + lines.size() > kMostWaiting) return false;
  shared_->waiting += lines;
  if (shared_->waiting.size() >= kWorthWriting) shared_->changed.notify_all();
  return true;
}

bool BackgroundFile::ended() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->ended;
}

const std::filesystem::path& BackgroundFile::path() const noexcept {
  return shared_->path;
}

void BackgroundFile::serve(const std::shared_ptr<Shared>& shared, const Write& write) {
  std::string chunk;
  std::unique_lock lock(shared->mutex);
  while (true) {
    shared->changed.wait_for(lock, kLongestWait, [&] {
      return shared->closing || shared->waiting.size() >= kWorthWriting;
    });
    if (shared->waiting.empty()) {
      if (shared->closing) break;
      continue;
    }
    chunk.swap(shared->waiting);
    lock.unlock();
    const int error = write_all(write, shared->file, chunk);
    chunk.clear();
    if (error != 0) {
      spdlog::warn("recording to {} ends here: {}", shared->path.string(), std::strerror(error));
    }
    lock.lock();
    if (error != 0) {
      shared->ended = true;
      shared->waiting.clear();
      break;
    }
  }
  shared->over = true;
  shared->changed.notify_all();
}

}  // namespace haptic::server
