#pragma once
/// Memory that one process writes and others read, as a file descriptor that it hands to them.

#include <cstddef>
#include <utility>

#include "server/base/descriptor.hpp"

namespace haptic::server {

/// Pages that are mapped as long as the object lives. All throw core::TransportError.
class SharedMemory {
 public:
  SharedMemory() = default;
  /// New memory, zeroed, in place and writable here and nowhere else, whose size is fixed.
  SharedMemory(const char* name, std::size_t bytes);
  /// Memory that another process made, to be read; refused if it is not of this size or could still
  /// shrink, because a page that is gone would end this process.
  SharedMemory(Descriptor descriptor, std::size_t bytes);
  SharedMemory(SharedMemory&& other) noexcept;
  SharedMemory& operator=(SharedMemory&& other) noexcept;
  ~SharedMemory();

  [[nodiscard]] void* data() const noexcept { return data_; }
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }
  /// For a reader: opened for it alone, so that what it does to its flags is its own affair.
  [[nodiscard]] Descriptor for_reader() const;

 private:
  void map(int protection);

  Descriptor descriptor_{};
  std::size_t bytes_{0};
  void* data_{nullptr};
};

}  // namespace haptic::server
