#include "server/owner/telemetry/new_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "haptic/core/error.hpp"

namespace haptic::server {
namespace {

namespace fs = std::filesystem;

/// More recordings of one name than a folder is pleasant with.
constexpr int kMostOfOneName = 100'000;
// Not to wait for the reader of a named pipe.
constexpr int kFlags = O_WRONLY | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;

[[noreturn]] void refuse(const fs::path& file, const std::string& why) {
  throw core::SceneError("record.file = '" + file.string() + "': cannot be created: " + why);
}

/// A device, a pipe, a folder or a link in the place of a recording is a mistake: refused, because
/// its user expects that something is written there.
void refuse_unless_regular(const fs::path& file) {
  struct stat status {};
  if (::lstat(file.c_str(), &status) != 0 || S_ISREG(status.st_mode)) return;
  refuse(file, S_ISLNK(status.st_mode) ? "is a symbolic link" : "is no regular file");
}

/// "run.csv", "run-2.csv", "run-3.csv", ...
fs::path numbered(const fs::path& file, int number) {
  if (number == 1) return file;
  fs::path other = file;
  other.replace_filename(file.stem().string() + "-" + std::to_string(number) +
                         file.extension().string());
  return other;
}

/// False if another process holds the lock. A file system that knows no locks grants it: O_EXCL
/// still gives each new file to one process.
bool lock(int descriptor) {
  return ::flock(descriptor, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

NewFile emptied(const fs::path& file) {
  refuse_unless_regular(file);
  const int descriptor = ::open(file.c_str(), kFlags, 0666);
  if (descriptor < 0) refuse(file, std::strerror(errno));
  struct stat status {};
  std::string why;
  if (::fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    why = "is no regular file";
  } else if (!lock(descriptor)) {
    why = "another process records in it";
  } else if (::ftruncate(descriptor, 0) != 0) {
    why = std::strerror(errno);
  }
  if (why.empty()) return {file, descriptor};
  ::close(descriptor);
  refuse(file, why);
}

}  // namespace

NewFile create_file(const fs::path& wanted, bool overwrite) {
  if (overwrite) return emptied(wanted);
  refuse_unless_regular(wanted);
  for (int number = 1; number <= kMostOfOneName; ++number) {
    const fs::path file = numbered(wanted, number);
    const int descriptor = ::open(file.c_str(), kFlags | O_EXCL, 0666);
    if (descriptor >= 0 && lock(descriptor)) return {file, descriptor};
    if (descriptor >= 0) {  // a process that overwrites was faster
      ::close(descriptor);
    } else if (errno != EEXIST) {
      refuse(file, std::strerror(errno));
    }
  }
  refuse(wanted, "there are " + std::to_string(kMostOfOneName) + " of that name");
}

void check_creatable(const fs::path& wanted, bool overwrite) {
  refuse_unless_regular(wanted);
  const fs::path file = fs::absolute(wanted);
  const bool written = overwrite && fs::exists(file);
  if (::access((written ? file : file.parent_path()).c_str(), W_OK) == 0) return;
  refuse(wanted, std::strerror(errno));
}

}  // namespace haptic::server
