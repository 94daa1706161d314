#include "server/crossing/shared_memory.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "haptic/core/error.hpp"

namespace haptic::server {
namespace {

[[noreturn]] void fail(const char* what) {
  throw core::TransportError(std::string("shared memory: ") + what + ": " + std::strerror(errno));
}

constexpr int kFixedSize = F_SEAL_SHRINK | F_SEAL_GROW;

}  // namespace

SharedMemory::SharedMemory(const char* name, std::size_t bytes)
    : descriptor_(memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING)), bytes_(bytes) {
  if (!descriptor_ || ftruncate(descriptor_.get(), static_cast<off_t>(bytes)) != 0) {
    fail("cannot be made");
  }
  map(PROT_READ | PROT_WRITE);
  // Every page now: no write waits for one later, and this process does not grow by use. Memory
  // that is locked as it is touched ignores MAP_POPULATE.
  std::memset(data_, 0, bytes_);
  // F_SEAL_FUTURE_WRITE spares the mapping that exists already: this process's own. It forbids
  // holes too.
  if (fcntl(descriptor_.get(), F_ADD_SEALS, kFixedSize | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL) != 0) {
    fail("cannot be sealed");
  }
  descriptor_ = for_reader();  // no process holds it for writing, this one included
}

SharedMemory::SharedMemory(Descriptor descriptor, std::size_t bytes)
    : descriptor_(std::move(descriptor)), bytes_(bytes) {
  struct stat status {};
  if (fstat(descriptor_.get(), &status) != 0) fail("no descriptor");
  if (static_cast<std::size_t>(status.st_size) != bytes) {
    throw core::TransportError("shared memory: has " + std::to_string(status.st_size) +
                               " bytes, must have " + std::to_string(bytes));
  }
  const int seals = fcntl(descriptor_.get(), F_GET_SEALS);
  if (seals < 0 || (seals & kFixedSize) != kFixedSize) {
    throw core::TransportError("shared memory: its size must be fixed");
  }
  map(PROT_READ);
}

SharedMemory::SharedMemory(SharedMemory&& other) noexcept
    : descriptor_(std::move(other.descriptor_)),
      bytes_(other.bytes_),
      data_(std::exchange(other.data_, nullptr)) {}

SharedMemory& SharedMemory::operator=(SharedMemory&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(bytes_, other.bytes_);
  std::swap(data_, other.data_);
  return *this;
}

SharedMemory::~SharedMemory() {
  if (data_ != nullptr) munmap(data_, bytes_);
}

Descriptor SharedMemory::for_reader() const {
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor_.get());
  Descriptor opened(open(link.c_str(), O_RDONLY | O_CLOEXEC));
  if (!opened) fail("cannot be opened for a reader");
  return opened;
}

void SharedMemory::map(int protection) {
  void* const mapped = mmap(nullptr, bytes_, protection, MAP_SHARED, descriptor_.get(), 0);
  if (mapped == MAP_FAILED) fail("cannot be mapped");
  data_ = mapped;
}

}  // namespace haptic::server
