#include "server/crossing/packet_socket.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <memory>

#include "server/base/steady_now.hpp"
#include "server/crossing/sample_socket.hpp"

namespace haptic::server {
namespace {

struct Message {
  int number{0};
  char text[60]{};
};

TEST(PacketSocket, AMessageBringsItsDescriptors) {
  const auto [here, there] = packet_pair();
  const Descriptor null(open("/dev/null", O_RDONLY));
  const int descriptor = null.get();
  ASSERT_TRUE(send(here.get(), Message{7, "seven"}, std::span(&descriptor, 1)));
  Message message;
  std::vector<Descriptor> brought;
  ASSERT_EQ(receive(there.get(), message, &brought), Received::kMessage);
  EXPECT_EQ(message.number, 7);
  EXPECT_EQ(brought.size(), 1U);
  EXPECT_EQ(receive(there.get(), message), Received::kNothing);
}

TEST(PacketSocket, MessageOfAnotherSizeIsDropped) {
  const auto [here, there] = packet_pair();
  ASSERT_TRUE(send(here.get(), 5));
  ASSERT_TRUE(send(here.get(), std::array<Message, 2>{}));
  ASSERT_TRUE(send(here.get(), Message{9, ""}));
  Message message{1, ""};
  EXPECT_EQ(receive(there.get(), message), Received::kOdd);
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

// One that both ends share would let the other one make this one wait.
TEST(PacketSocket, EndsShareNoFlags) {
  const auto [here, there] = packet_pair();
  ASSERT_EQ(fcntl(there.get(), F_SETFL, 0), 0);
  Message message;
  EXPECT_NE(fcntl(here.get(), F_GETFL) & O_NONBLOCK, 0);
  EXPECT_EQ(receive(here.get(), message), Received::kNothing);
  shutdown(there.get(), SHUT_RDWR);
  EXPECT_EQ(receive(here.get(), message), Received::kGone);
}

/// A socket whose last close() waits for `seconds`: it has sent what is not read.
Descriptor lingering(int seconds, Descriptor& peer) {
  const Descriptor listener(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in name{};
  name.sin_family = AF_INET;
  name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof name;
  EXPECT_EQ(bind(listener.get(), reinterpret_cast<sockaddr*>(&name), size), 0);
  EXPECT_EQ(listen(listener.get(), 1), 0);
  EXPECT_EQ(getsockname(listener.get(), reinterpret_cast<sockaddr*>(&name), &size), 0);
  Descriptor made(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  connect(made.get(), reinterpret_cast<sockaddr*>(&name), size);
  peer = Descriptor(accept(listener.get(), nullptr, nullptr));
  const std::string much(1 << 16, 'x');
  while (::send(made.get(), much.data(), much.size(), MSG_NOSIGNAL) > 0) continue;
  const linger wait{1, seconds};
  setsockopt(made.get(), SOL_SOCKET, SO_LINGER, &wait, sizeof wait);
  return made;
}

TEST(PacketSocket, NoStrangersDescriptorIsClosedHere) {
  constexpr auto kSoon = std::chrono::milliseconds(500);
  Descriptor peer;
  auto [here, there] = packet_pair();
  {
    const Descriptor slow = lingering(2, peer);
    const int descriptor = slow.get();
    ASSERT_TRUE(send(there.get(), Message{1, ""}));
    ASSERT_TRUE(send(there.get(), Message{2, ""}, std::span(&descriptor, 1)));
  }
  const core::TimePoint began = steady_now();
  Message message;
  EXPECT_EQ(receive(here.get(), message), Received::kMessage);
  EXPECT_EQ(receive(here.get(), message), Received::kBurdened);
  EXPECT_EQ(receive(here.get(), message), Received::kBurdened) << "it stays";
  close_aside(std::move(here));
  EXPECT_LT(steady_now() - began, kSoon);
  EXPECT_EQ(closing_aside(), 1);
  EXPECT_FALSE(send(there.get(), message)) << "it gets nothing more";
  while (closing_aside() != 0) usleep(10'000);
}

TEST(PacketSocket, EmptyOnesCloseAtOnce) {
  auto [here, there] = packet_pair();
  ASSERT_TRUE(send(there.get(), Message{}));
  close_aside(std::move(here));
  EXPECT_EQ(closing_aside(), 0);
}

TEST(SampleSocket, ThePlanesThatCountCross) {
  const auto [here, there] = packet_pair();
  auto sample = std::make_unique<ProxySample>(), got = std::make_unique<ProxySample>();
  for (const std::uint32_t count : {2U, 0U, 32U, 33U, ~0U}) {
    sample->plane_count = count;
    for (PlaneSample& plane : sample->planes) plane.offset = count;
    for (PlaneSample& plane : got->planes) plane.offset = -1.0;
    ASSERT_TRUE(send_sample(there.get(), SampleKind::kProxy, *sample));
    const Next next = look_at_next(here.get());
    EXPECT_EQ(static_cast<SampleKind>(next.word), SampleKind::kProxy);
    ASSERT_TRUE(take_sample(here.get(), next.bytes, *got));
    EXPECT_EQ(got->plane_count, count);
    for (std::uint32_t i = 0; i < got->planes.size(); ++i) {
      EXPECT_EQ(got->planes[i].offset, i < count ? count : -1.0) << count;
    }
  }
}

TEST(SampleSocket, ASizeThatLiesIsRefused) {
  const auto [here, there] = packet_pair();
  auto sample = std::make_unique<ProxySample>();
  sample->plane_count = 1;
  const Bytes bytes = bytes_of(*sample);
  const std::uint64_t kind = 1;
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{8}, ProxySample::head_bytes(), sample->told_bytes() - 1,
        sample->told_bytes() + 1, bytes.size()}) {
    ASSERT_TRUE(send_bytes(there.get(), bytes_of(kind), bytes.first(size)));
    EXPECT_FALSE(take_sample(here.get(), look_at_next(here.get()).bytes, *sample)) << size;
    sample->plane_count = 1;
  }
  EXPECT_EQ(look_at_next(here.get()).what, Received::kNothing) << "it is thrown away";
}

}  // namespace
}  // namespace haptic::server
