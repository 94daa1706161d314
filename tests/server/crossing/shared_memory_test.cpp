#include "server/crossing/shared_memory.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>

#include "haptic/core/error.hpp"
#include "server/crossing/packet_socket.hpp"

namespace {

using haptic::core::TransportError;
using haptic::server::Descriptor;
using haptic::server::packet_pair;
using haptic::server::receive;
using haptic::server::Received;
using haptic::server::send;
using haptic::server::SharedMemory;
using Access = SharedMemory::Access;

Descriptor copy_of(const SharedMemory& memory) {
  return Descriptor(dup(memory.descriptor()));
}

TEST(SharedMemory, TheOtherReadsWhatIsWritten) {
  const SharedMemory owner("test", 4096, Access::kRead);
  const SharedMemory front(copy_of(owner), 4096, Access::kRead);
  std::strcpy(static_cast<char*>(owner.data()), "hello");
  EXPECT_STREQ(static_cast<const char*>(front.data()), "hello");
}

TEST(SharedMemory, OwnersPagesCannotBeWritten) {
  const SharedMemory owner("test", 4096, Access::kRead);
  EXPECT_THROW(SharedMemory(copy_of(owner), 4096, Access::kReadAndWrite), TransportError);
  const SharedMemory front(copy_of(owner), 4096, Access::kRead);
  EXPECT_EQ(mprotect(front.data(), 4096, PROT_READ | PROT_WRITE), -1);
  EXPECT_EQ(pwrite(owner.descriptor(), "x", 1, 0), -1);
}

TEST(SharedMemory, ItsSizeIsFixed) {
  const SharedMemory memory("test", 4096, Access::kReadAndWrite);
  EXPECT_EQ(ftruncate(memory.descriptor(), 0), -1);
  EXPECT_EQ(ftruncate(memory.descriptor(), 1 << 20), -1);
  EXPECT_THROW(SharedMemory(copy_of(memory), 8192, Access::kRead), TransportError);
}

TEST(SharedMemory, NewMemoryIsInPlace) {
  constexpr std::size_t kPages = 16;
  const SharedMemory memory("test", kPages * 4096, Access::kRead);
  struct stat status {};
  ASSERT_EQ(fstat(memory.descriptor(), &status), 0);
  EXPECT_EQ(512 * status.st_blocks, static_cast<blkcnt_t>(kPages * 4096));
}

TEST(SharedMemory, MemoryThatCouldShrinkIsRefused) {
  Descriptor loose(memfd_create("test", MFD_CLOEXEC));
  ASSERT_EQ(ftruncate(loose.get(), 4096), 0);
  EXPECT_THROW(SharedMemory(std::move(loose), 4096, Access::kRead), TransportError);
}

struct Message {
  int number{0};
  char text[60]{};
};

TEST(PacketSocket, AMessageBringsItsDescriptors) {
  const auto [here, there] = packet_pair();
  const SharedMemory memory("test", 4096, Access::kRead);
  const int descriptor = memory.descriptor();
  ASSERT_TRUE(send(here.get(), Message{7, "seven"}, std::span(&descriptor, 1)));
  Message message;
  std::vector<Descriptor> brought;
  ASSERT_EQ(receive(there.get(), message, &brought), Received::kMessage);
  EXPECT_EQ(message.number, 7);
  ASSERT_EQ(brought.size(), 1U);
  EXPECT_NO_THROW(SharedMemory(std::move(brought[0]), 4096, Access::kRead));
  EXPECT_EQ(receive(there.get(), message), Received::kNothing);
}

TEST(PacketSocket, MessageOfAnotherSizeIsDropped) {
  const auto [here, there] = packet_pair();
  ASSERT_TRUE(send(here.get(), 5));
  ASSERT_TRUE(send(here.get(), Message{9, ""}));
  Message message{1, ""};
  EXPECT_EQ(receive(there.get(), message), Received::kOdd);
  EXPECT_EQ(message.number, 1);
  EXPECT_EQ(receive(there.get(), message), Received::kMessage);
  EXPECT_EQ(message.number, 9);
}

TEST(PacketSocket, AFullQueueBlocksNobody) {
  const auto [here, there] = packet_pair();
  int sent = 0;
  while (send(here.get(), Message{sent, ""}) && sent < 1'000'000) ++sent;
  EXPECT_GT(sent, 8);
  EXPECT_LT(sent, 1'000'000);
}

TEST(PacketSocket, EndThatIsGoneIsTold) {
  auto [here, there] = packet_pair();
  there = Descriptor();
  EXPECT_FALSE(send(here.get(), Message{}));
  Message message;
  EXPECT_EQ(receive(here.get(), message), Received::kGone);
}

}  // namespace
