#include "server/crossing/shared_memory.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <string>

#include "haptic/core/error.hpp"
namespace {

using haptic::core::TransportError;
using haptic::server::Descriptor;
using haptic::server::SharedMemory;

TEST(SharedMemory, TheOtherReadsWhatIsWritten) {
  const SharedMemory owner("test", 4096);
  const SharedMemory front(owner.for_reader(), 4096);
  std::strcpy(static_cast<char*>(owner.data()), "hello");
  EXPECT_STREQ(static_cast<const char*>(front.data()), "hello");
}

/// Everything that a process with a reader's descriptor, and as the same user, may try.
TEST(SharedMemory, ItsReadersChangeNothing) {
  constexpr std::size_t kBytes = 16 * 4096;
  const SharedMemory owner("test", kBytes);
  std::memset(owner.data(), 7, kBytes);
  const SharedMemory front(owner.for_reader(), kBytes);
  const Descriptor given = owner.for_reader();
  EXPECT_EQ(mprotect(front.data(), 4096, PROT_READ | PROT_WRITE), -1);
  for (const int advice : {MADV_REMOVE, MADV_DONTNEED, MADV_COLD, MADV_PAGEOUT, MADV_FREE}) {
    madvise(front.data(), kBytes, advice);
  }
  fchmod(given.get(), 0777);
  const std::string link = "/proc/self/fd/" + std::to_string(given.get());
  const Descriptor again(open(link.c_str(), O_RDWR | O_CLOEXEC));
  for (const int descriptor : {given.get(), again.get()}) {
    const int hole = FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE;
    EXPECT_EQ(fallocate(descriptor, hole, 0, 4096), -1);
    EXPECT_EQ(fallocate(descriptor, FALLOC_FL_ZERO_RANGE, 0, 4096), -1);
    EXPECT_EQ(pwrite(descriptor, "x", 1, 0), -1);
    EXPECT_EQ(ftruncate(descriptor, 0), -1);
    EXPECT_EQ(ftruncate(descriptor, 1 << 20), -1);
    EXPECT_EQ(fcntl(descriptor, F_ADD_SEALS, F_SEAL_WRITE), -1);
    EXPECT_EQ(mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0), MAP_FAILED);
    posix_fadvise(descriptor, 0, 0, POSIX_FADV_DONTNEED);
  }
  std::array<unsigned char, 16> resident{};
  ASSERT_EQ(mincore(owner.data(), kBytes, resident.data()), 0);
  for (std::size_t page = 0; page < resident.size(); ++page) {
    EXPECT_EQ(resident[page] & 1U, 1U);
    EXPECT_EQ(static_cast<const char*>(owner.data())[4096 * page], 7);
  }
}

TEST(SharedMemory, ReadersShareNoFlags) {
  const SharedMemory owner("test", 4096);
  const Descriptor one = owner.for_reader(), other = owner.for_reader();
  ASSERT_EQ(fcntl(one.get(), F_SETFL, O_NONBLOCK), 0);
  EXPECT_EQ(fcntl(other.get(), F_GETFL) & O_NONBLOCK, 0);
}

TEST(SharedMemory, NewMemoryIsInPlace) {
  constexpr std::size_t kPages = 16;
  const SharedMemory memory("test", kPages * 4096);
  struct stat status {};
  ASSERT_EQ(fstat(memory.for_reader().get(), &status), 0);
  EXPECT_EQ(512 * status.st_blocks, static_cast<blkcnt_t>(kPages * 4096));
}

TEST(SharedMemory, AnotherSizeIsRefused) {
  const SharedMemory memory("test", 4096);
  EXPECT_THROW(SharedMemory(memory.for_reader(), 8192), TransportError);
  Descriptor loose(memfd_create("test", MFD_CLOEXEC));
  ASSERT_EQ(ftruncate(loose.get(), 4096), 0);
  EXPECT_THROW(SharedMemory(std::move(loose), 4096), TransportError);
}

}  // namespace
