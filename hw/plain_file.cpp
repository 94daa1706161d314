#include "hw/plain_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace haptic::hw {

int open_plain_file(const std::filesystem::path& file, std::uintmax_t most, std::string& why) {
  // Without O_NONBLOCK the opening of a pipe waits for its writer.
  const int opened = open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  struct stat status {};
  if (opened < 0 || fstat(opened, &status) != 0) {
    why = std::string("cannot be read: ") + std::strerror(errno);
  } else if (S_ISDIR(status.st_mode)) {
    why = "cannot be read: is a folder, must be a plain file";
  } else if (!S_ISREG(status.st_mode)) {
    why = "cannot be read: must be a plain file";
  } else if (static_cast<std::uintmax_t>(status.st_size) > most) {
    why = "has " + std::to_string(status.st_size) + " bytes, must have at most " +
          std::to_string(most);
  } else {
    return opened;
  }
  if (opened >= 0) close(opened);
  return -1;
}

std::string read_plain_file(const std::filesystem::path& file, std::uintmax_t most,
                            std::string& why) {
  const int opened = open_plain_file(file, most, why);
  if (opened < 0) return {};
  std::string text;
  char part[16384];
  ssize_t got = 1;
  while (got > 0 && text.size() <= most) {
    got = read(opened, part, sizeof part);
    if (got > 0) text.append(part, static_cast<std::size_t>(got));
  }
  if (got < 0) why = std::string("cannot be read: ") + std::strerror(errno);
  close(opened);
  if (text.size() > most) why = "has more than " + std::to_string(most) + " bytes";
  const bool wide = text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF");
  if (wide) why = "is UTF-16, must be UTF-8";
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  return why.empty() ? text : std::string();
}

}  // namespace haptic::hw
