#include "server/telemetry/background_file.hpp"

#include <fcntl.h>
#include <pthread.h>
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

#include "haptic/core/error.hpp"

namespace haptic::server {
namespace {

/// About a quarter of a second of a finger's rows: what a killed server may lose at most.
constexpr std::size_t kWorthWriting = 128 * 1024;
constexpr std::chrono::seconds kLastPatience{1};

/// All of `text`; 0 or the error.
int write_all(const BackgroundFile::Write& write, int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t done = write(file, text.data(), text.size());
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) return done < 0 ? errno : ENOSPC;
    text.remove_prefix(static_cast<std::size_t>(done));
  }
  return 0;
}

}  // namespace

/// Outlives the BackgroundFile where the disk hangs: then only the thread holds it.
struct BackgroundFile::Shared {
  explicit Shared(std::filesystem::path file_path, int file_number)
      : path(std::move(file_path)), file(file_number) {}
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

BackgroundFile::BackgroundFile(const std::filesystem::path& file, Write write) {
  // Not to wait for the reader of a named pipe, neither here nor later.
  const int number =
      ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NONBLOCK, 0666);
  if (number < 0) {
    throw core::SceneError("record.file = '" + file.string() +
                           "': cannot be created: " + std::strerror(errno));
  }
  shared_ = std::make_shared<Shared>(file, number);
  if (!write) write = ::write;
  std::thread([shared = shared_, write = std::move(write)] {
    pthread_setname_np(pthread_self(), "haptic-record");
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

bool BackgroundFile::append(std::string_view text) {
  const std::lock_guard lock(shared_->mutex);
  if (shared_->ended || shared_->waiting.size() + text.size() > kMostWaiting) return false;
  shared_->waiting += text;
  if (shared_->waiting.size() >= kWorthWriting) shared_->changed.notify_all();
  return true;
}

bool BackgroundFile::ended() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->ended;
}

void BackgroundFile::serve(const std::shared_ptr<Shared>& shared, const Write& write) {
  std::string chunk;
  std::unique_lock lock(shared->mutex);
  while (true) {
    shared->changed.wait(
        lock, [&] { return shared->closing || shared->waiting.size() >= kWorthWriting; });
    if (shared->waiting.empty() || shared->ended) break;
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
