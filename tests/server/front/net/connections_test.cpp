#include "server/front/net/connections.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <array>
#include <functional>
#include <mutex>

#include "server/owner/link/listeners.hpp"
#include "tests/server/support/port_of.hpp"
#include "tests/support/within.hpp"

namespace haptic::test {
namespace {

using namespace std::chrono_literals;
using server::ConnectionLimits;
using server::Connections;
using server::Descriptor;

std::vector<Connections::Listener> listeners(const server::Listeners& bound) {
  std::vector<Connections::Listener> all;
  for (Descriptor& socket : bound.sockets()) all.push_back({std::move(socket), 0});
  return all;
}

/// A service that keeps every connection and reads what comes, as gRPC would.
class Door {
 public:
  explicit Door(const ConnectionLimits& limits) : connections(listeners(bound_), limits) {
    connections.start(
        [this](std::size_t, int descriptor, std::shared_ptr<server::Account> account) {
          const std::lock_guard lock(mutex_);
          accepted_.emplace_back(descriptor);
          accounts_.push_back(std::move(account));
        });
  }

  [[nodiscard]] int port() const { return port_of(bound_.addresses()[0].name); }
  [[nodiscard]] std::size_t accepted() {
    const std::lock_guard lock(mutex_);
    return accepted_.size();
  }
  /// Closes the first one, as a service does that does not shut it down.
  void close_first() {
    const std::lock_guard lock(mutex_);
    accepted_.front() = Descriptor();
    accounts_.front()->leave();
  }
  void read_all() {
    const std::lock_guard lock(mutex_);
    std::array<char, 65536> bytes{};
    for (const Descriptor& each : accepted_) {
      while (recv(each.get(), bytes.data(), bytes.size(), MSG_DONTWAIT) > 0) continue;
    }
  }

 private:
  std::mutex mutex_;
  std::vector<Descriptor> accepted_{};
  std::vector<std::shared_ptr<server::Account>> accounts_{};
  const server::Listeners bound_{{{"127.0.0.1:0"}}, false};

 public:
  Connections connections;
};

sockaddr_in loopback(int port) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return to;
}

class Caller {
 public:
  explicit Caller(int port) : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    const sockaddr_in to = loopback(port);
    EXPECT_EQ(connect(socket_.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
    sockaddr_in own{};
    socklen_t size = sizeof own;
    getsockname(socket_.get(), reinterpret_cast<sockaddr*>(&own), &size);
    name_ = "ipv4:127.0.0.1:" + std::to_string(ntohs(own.sin_port));
  }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] bool cut() const {
    pollfd wait{socket_.get(), POLLIN, 0};
    return poll(&wait, 1, 0) > 0;  // no one sends here: readable is ended
  }
  /// False: the connection is over.
  bool send(std::size_t bytes) {
    const std::string text(bytes, 'x');
    return ::send(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL) ==
           static_cast<ssize_t>(bytes);
  }

 private:
  Descriptor socket_;
  std::string name_{};
};

TEST(Connections, TheOldestSilentOneGivesWay) {
  Door door({.all = 4, .per_peer = 4});
  const Caller session(door.port());
  ASSERT_TRUE(eventually([&] { return door.accepted() == 1; }));
  door.connections.account(session.name())->session_opened();
  const Caller called(door.port());
  ASSERT_TRUE(eventually([&] { return door.accepted() == 2; }));
  door.connections.account(called.name())->call(0);
  std::vector<Caller> silent;
  for (int i = 0; i < 12; ++i) silent.emplace_back(door.port());
  ASSERT_TRUE(eventually([&] { return door.accepted() == 14; }));
  EXPECT_TRUE(eventually([&] { return silent[9].cut(); }));
  EXPECT_FALSE(session.cut());
  EXPECT_FALSE(called.cut());
  EXPECT_FALSE(silent[11].cut());
  EXPECT_EQ(door.connections.cut(), 10U);
}

TEST(Connections, OnePeerLeavesRoomForOthers) {
  Door door({.all = 8, .per_peer = 2});
  std::vector<Caller> callers;
  for (int i = 0; i < 3; ++i) callers.emplace_back(door.port());
  EXPECT_TRUE(eventually([&] { return callers[0].cut(); }));
  EXPECT_FALSE(callers[2].cut());
}

TEST(Connections, WhatNobodyReadsIsNoDebt) {
  Door door({.debt = 8192});
  Caller caller(door.port());
  ASSERT_TRUE(eventually([&] { return door.accepted() == 1; }));
  ASSERT_TRUE(caller.send(32'768));
  std::this_thread::sleep_for(100ms);
  EXPECT_FALSE(caller.cut());
}

TEST(Connections, WhatItsServiceClosedIsClosed) {
  Door door({});
  Caller left(door.port()), stays(door.port());
  ASSERT_TRUE(eventually([&] { return door.accepted() == 2; }));
  door.close_first();
  EXPECT_TRUE(eventually([&] { return left.cut(); }));
  EXPECT_TRUE(eventually([&] { return door.connections.open() == 1; }));
  EXPECT_FALSE(stays.cut());
  EXPECT_EQ(door.connections.cut(), 0U);
}

TEST(Connections, FloodsBeforeAcceptanceAreRefused) {
  const server::Listeners bound({{"127.0.0.1:0"}}, false);
  Connections door(listeners(bound), {});
  const int port = port_of(bound.addresses()[0].name);
  Caller flood(port);
  Caller early(port);
  ASSERT_TRUE(flood.send(20'000));
  ASSERT_TRUE(early.send(2'000));
  std::vector<Descriptor> accepted;
  door.start([&](std::size_t, int descriptor, const std::shared_ptr<server::Account>&) {
    accepted.emplace_back(descriptor);
  });
  EXPECT_TRUE(eventually([&] { return door.open() == 1; }));
  EXPECT_TRUE(eventually([&] { return flood.cut(); }));
  EXPECT_FALSE(early.cut());
}

TEST(Connections, AllDebtsTogetherAreBounded) {
  Door door({.debt = 64 * 1024, .debt_of_all = 32 * 1024, .forgiven_per_second = 0});
  std::vector<Caller> callers;
  for (int i = 0; i < 8; ++i) callers.emplace_back(door.port());
  ASSERT_TRUE(eventually([&] { return door.accepted() == 8; }));
  for (std::size_t i = 0; i < 8; ++i) ASSERT_TRUE(callers[i].send(i == 3 ? 12'000 : 6'000));
  EXPECT_TRUE(eventually([&] {
    door.read_all();
    return callers[3].cut();
  }));
}

/// The process grows by 2 MB at a time, with a little from the caller each time, until that is cut.
void grow_until_cut(
    Door& door, Caller& caller, const std::function<void()>& meanwhile = [] {}) {
  std::vector<std::string> memory;
  for (int i = 0; i < 200 && !caller.cut(); ++i) {
    meanwhile();
    caller.send(1024);
    door.read_all();
    memory.emplace_back(2 << 20, 'x');
    std::this_thread::sleep_for(10ms);
  }
}

TEST(Connections, GrowingMemoryCutsItsCause) {
  Door door({.growth = 4 << 20, .memory = 8ULL << 30});
  Caller quiet(door.port()), streams(door.port()), caller(door.port());
  ASSERT_TRUE(eventually([&] { return door.accepted() == 3; }));
  const auto samples = door.connections.account(streams.name());
  grow_until_cut(door, caller, [&] {
    quiet.send(16);
    samples->message(1024);
    streams.send(1024);
  });
  EXPECT_TRUE(caller.cut());
  EXPECT_FALSE(quiet.cut());
  EXPECT_FALSE(streams.cut());
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // whose malloc counts nothing
TEST(Connections, FullMemoryShutsTheDoor) {
  Door door({.growth = 4 << 20, .memory = 1});
  Caller caller(door.port());
  ASSERT_TRUE(eventually([&] { return door.accepted() == 1; }));
  grow_until_cut(door, caller);
  const auto cut = std::chrono::steady_clock::now();
  const Caller next(door.port());
  EXPECT_TRUE(eventually([&] { return door.accepted() == 2; })) << "not for ever";
  EXPECT_GE(std::chrono::steady_clock::now() - cut, 4s);
}
#endif

TEST(Connections, RunningOutOfDescriptorsDeafensNobody) {
  rlimit former{};
  getrlimit(RLIMIT_NOFILE, &former);
  Door door({});
  std::vector<Caller> callers;
  for (int i = 0; i < 40; ++i) callers.emplace_back(door.port());
  ASSERT_TRUE(eventually([&] { return door.accepted() == 40; }));
  // No descriptor is left now, for either end.
  const Descriptor next(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const rlimit none{static_cast<rlim_t>(next.get()) + 1, former.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &none), 0);
  const sockaddr_in to = loopback(door.port());
  EXPECT_EQ(connect(next.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
  EXPECT_TRUE(eventually([&] { return door.connections.cut() >= 1; }));
  setrlimit(RLIMIT_NOFILE, &former);
  const std::size_t before = door.accepted();
  const Caller late(door.port());
  EXPECT_TRUE(eventually([&] { return door.accepted() > before; }));
}

TEST(Connections, ClosingCutsWhatStays) {
  Door door({});
  const Caller caller(door.port());
  ASSERT_TRUE(eventually([&] { return door.accepted() == 1; }));
  door.connections.close(50ms);
  EXPECT_TRUE(eventually([&] { return caller.cut(); }));
}

TEST(Connections, FewDescriptorsAreRefusedByNumber) {
  rlimit former{};
  getrlimit(RLIMIT_NOFILE, &former);
  const rlimit few{40, former.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &few), 0);
  EXPECT_LE(server::within_descriptors({}).all, 256U);  // raised to the hard limit
  rlimit raised{};
  getrlimit(RLIMIT_NOFILE, &raised);
  EXPECT_GT(raised.rlim_cur, 40U);
  setrlimit(RLIMIT_NOFILE, &former);
}

TEST(Debt, GoodConductSavesNothingUp) {
  server::Debt debt;
  debt.book({.understood = 1'000'000, .received = 0, .acknowledged = 1'000'000}, 5e3);
  debt.book({.understood = 1'000'000, .received = 7'000, .acknowledged = 1'000'000}, 0.0);
  EXPECT_DOUBLE_EQ(debt.bytes(), 7'000.0);
}

TEST(Suspicion, MessagesOfStreamsAreNone) {
  server::Suspicion suspicion;
  suspicion.book({.messages = 40'000, .received = 40'100}, 0.01);
  EXPECT_DOUBLE_EQ(suspicion.bytes(), 100.0);
  suspicion.book({.messages = 40'000, .received = 45'100}, 0.0);
  EXPECT_DOUBLE_EQ(suspicion.bytes(), 5'100.0);
  suspicion.book({.messages = 40'000, .received = 45'100}, 1.0);
  EXPECT_DOUBLE_EQ(suspicion.bytes(), 0.0);
}

/// gRPC's client answers a state per millisecond, a little before or after the acknowledgement.
TEST(Suspicion, AListenersAnswersAreNone) {
  server::Suspicion suspicion;
  server::Traffic traffic;
  for (int i = 0; i < 1000; ++i) {
    traffic.received += i % 2 == 0 ? 940 : 0;
    traffic.acknowledged += 3440;
    suspicion.book(traffic, 0.01);
  }
  EXPECT_LT(suspicion.bytes(), 1024.0);
}

TEST(Debt, AListenersWindowUpdatesAreFree) {
  // 1000 states of 120 bytes each second, answered by 13 bytes of window and 17 of a ping.
  server::Debt debt;
  server::Traffic now;
  for (int i = 0; i < 3'600'000; ++i) {
    now.acknowledged += 120;
    debt.book(now, 0.0);
    now.received += 30;
  }
  EXPECT_LE(debt.bytes(), 60.0);
}

}  // namespace
}  // namespace haptic::test
