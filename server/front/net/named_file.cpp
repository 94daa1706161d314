#include "server/front/net/named_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "haptic/core/error.hpp"

namespace haptic::server {
namespace {

/// The owner looked at the size, which may have changed since.
constexpr std::size_t kLargest = 1 << 20;

}  // namespace

std::string read_named(const std::string& name, const Descriptor& file) {
  std::string text(kLargest + 1, '\0');
  std::size_t size = 0;
  for (ssize_t got = 1; got > 0 && size < text.size(); size += static_cast<std::size_t>(got)) {
    got = pread(file.get(), text.data() + size, text.size() - size, static_cast<off_t>(size));
    if (got < 0) {
      throw core::TransportError(name + ": cannot be read: " + std::strerror(errno));
    }
  }
  if (size > kLargest) throw core::TransportError(name + ": has more than 1 MB");
  text.resize(size);
  return text;
}

}  // namespace haptic::server
