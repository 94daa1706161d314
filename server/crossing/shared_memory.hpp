#pragma once
/// Memory that two processes share, as a file descriptor that one hands to the other.

#include <cstddef>
#include <utility>

#include "server/base/descriptor.hpp"

namespace haptic::server {

/// Pages that are mapped as long as the object lives. All throw core::TransportError.
class SharedMemory {
 public:
  enum class Access { kRead, kReadAndWrite };

  SharedMemory() = default;
  /// New memory, zeroed, in place and writable here, whose size is fixed. kRead: no other process
  /// can ever map it writable, not even with this descriptor.
  SharedMemory(const char* name, std::size_t bytes, Access of_the_other);
  /// Memory that the other process made; refused if it is not of this size or could still shrink,
  /// because a page that is gone would end this process.
  SharedMemory(Descriptor descriptor, std::size_t bytes, Access access);
  SharedMemory(SharedMemory&& other) noexcept;
  SharedMemory& operator=(SharedMemory&& other) noexcept;
  ~SharedMemory();

  [[nodiscard]] void* data() const noexcept { return data_; }
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }
  [[nodiscard]] int descriptor() const noexcept { return descriptor_.get(); }

 private:
  void map(Access access);

  Descriptor descriptor_{};
  std::size_t bytes_{0};
  void* data_{nullptr};
};

}  // namespace haptic::server
