#include "tests/support/allocation_guard.hpp"

#include <cstddef>

// Two ways to the same count. A plain build puts its own malloc family in front of glibc's: the
// dynamic linker prefers the program's definition, so libstdc++'s operator new and every library
// come through here, and glibc's own entry points need no dlsym (which would allocate). Under a
// sanitizer the allocator belongs to its run time, which offers hooks instead.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define HAPTIC_ALLOCATOR_IS_THE_SANITIZERS 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define HAPTIC_ALLOCATOR_IS_THE_SANITIZERS 1
#endif
#endif

namespace {

// initial-exec: reading the counter must not itself allocate a thread's storage.
struct Counts {
  std::uint64_t allocations;
  std::uint64_t releases;
};
[[gnu::tls_model("initial-exec")]] constinit thread_local Counts counts{};

}  // namespace

#ifdef HAPTIC_ALLOCATOR_IS_THE_SANITIZERS

// Declared here because g++ ships the run time without its allocator_interface.h.
// NOLINTNEXTLINE(bugprone-reserved-identifier): the sanitizer's name.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void*,
                                                                           std::size_t),
                                                         void (*on_free)(const volatile void*));

namespace {

void on_malloc(const volatile void*, std::size_t) {
  ++counts.allocations;
}
void on_free(const volatile void* block) {
  if (block != nullptr) ++counts.releases;
}
[[maybe_unused]] const int installed =
    __sanitizer_install_malloc_and_free_hooks(&on_malloc, &on_free);

}  // namespace

#else

#include <cerrno>
#include <cstdint>

extern "C" {

// NOLINTBEGIN(bugprone-reserved-identifier): glibc's names for its own allocator.
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* block, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
void __libc_free(void* block);
// NOLINTEND(bugprone-reserved-identifier)

void* malloc(std::size_t size) noexcept {
  ++counts.allocations;
  return __libc_malloc(size);
}

void* calloc(std::size_t count, std::size_t size) noexcept {
  ++counts.allocations;
  return __libc_calloc(count, size);
}

void* realloc(void* block, std::size_t size) noexcept {
  ++counts.allocations;
  if (block != nullptr) ++counts.releases;
  return __libc_realloc(block, size);
}

void* reallocarray(void* block, std::size_t count, std::size_t size) noexcept {
  std::size_t bytes = 0;
  if (__builtin_mul_overflow(count, size, &bytes)) {
    errno = ENOMEM;
    return nullptr;
  }
  return realloc(block, bytes);
}

void* memalign(std::size_t alignment, std::size_t size) noexcept {
  ++counts.allocations;
  return __libc_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  return memalign(alignment, size);
}

int posix_memalign(void** block, std::size_t alignment, std::size_t size) noexcept {
  const bool power_of_two = alignment != 0 && (alignment & (alignment - 1)) == 0;
  if (!power_of_two || alignment % sizeof(void*) != 0) return EINVAL;
  void* const got = memalign(alignment, size);
  if (got == nullptr) return ENOMEM;
  *block = got;
  return 0;
}

void free(void* block) noexcept {
  if (block != nullptr) ++counts.releases;
  __libc_free(block);
}

}  // extern "C"

#endif

namespace haptic::test {

AllocationGuard::AllocationGuard() noexcept
    : allocations_(counts.allocations), releases_(counts.releases) {}

std::uint64_t AllocationGuard::allocations() const noexcept {
  return counts.allocations - allocations_;
}

std::uint64_t AllocationGuard::releases() const noexcept {
  return counts.releases - releases_;
}

}  // namespace haptic::test
