#include "server/owner/telemetry/telemetry.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/support/device_rig.hpp"

namespace {

using namespace std::chrono_literals;
using haptic::core::TickRecord;
using haptic::server::RecordListener;
using haptic::server::Telemetry;
using haptic::test::DeviceRig;

/// Writes its letter into a shared diary: small for every record, `!` after it for the newest.
class Diarist final : public RecordListener {
 public:
  Diarist(std::string& diary, std::string letter) : diary_(diary), letter_(std::move(letter)) {}
  void on_record(const TickRecord&) override { diary_ += letter_; }
  void on_newest(const TickRecord&) override { diary_ += letter_ + "!"; }

 private:
  std::string& diary_;
  std::string letter_;
};

void tick(DeviceRig& rig, int n) {
  for (int i = 0; i < n; ++i) {
    rig.now += 1ms;
    rig.unit->tick(rig.now, 1ms, {});
  }
}

TEST(Telemetry, ListenersAreCalledInTheirOrder) {
  DeviceRig rig;
  std::string diary;
  Diarist a(diary, "a"), b(diary, "b");
  rig.telemetry->add(0, &b);
  rig.telemetry->add(0, &a);
  tick(rig, 2);
  rig.telemetry->drain();
  rig.telemetry->drain();  // nothing is new: no listener is called
  rig.telemetry->remove(0, &b);
  tick(rig, 1);
  rig.telemetry->drain();
  EXPECT_EQ(diary, "babab!a!aa!");
  rig.telemetry->remove(0, &a);
}

TEST(Telemetry, WatchersKeepProcessorsAwake) {
  DeviceRig rig;
  std::vector<bool> told;
  rig.telemetry->on_watched([&](bool awake) { told.push_back(awake); });
  for (const int change : {1, 1, -1}) rig.telemetry->watch(change);
  EXPECT_EQ(told, std::vector<bool>{true});
  rig.telemetry->watch(-1);
  EXPECT_EQ(told, (std::vector<bool>{true, false}));
  rig.telemetry->watch(1);
  rig.telemetry->start();
  rig.telemetry->stop();  // with a client that never ended
  EXPECT_EQ(told, (std::vector<bool>{true, false, true, false}));
}

// A loop that ticks as fast as it can, the drain awake by its bell alone, four threads that come
// and go: none is called after remove() returned. What matters most is that tsan finds nothing.
TEST(Telemetry, RemovedListenerIsNeverCalled) {
  struct Visitor final : RecordListener {
    std::atomic<bool> present{false};
    std::atomic<int> calls{0};
    std::atomic<int> calls_while_away{0};
    void on_record(const TickRecord&) override {
      ++calls;
      if (!present) ++calls_while_away;
    }
  };
  DeviceRig rig;
  rig.telemetry->start();
  std::atomic<bool> running{true};
  std::thread loop([&] {
    while (running) {
      tick(rig, 1);
      rig.telemetry->bell().ring();
      std::this_thread::yield();
    }
  });
  std::vector<Visitor> visitors(4);
  std::vector<std::thread> threads;
  for (Visitor& visitor : visitors) {
    threads.emplace_back([&] {
      for (int i = 0; i < 200; ++i) {
        const int before = visitor.calls;
        visitor.present = true;
        rig.telemetry->add(0, &visitor);
        while (visitor.calls == before) std::this_thread::yield();
        rig.telemetry->remove(0, &visitor);
        visitor.present = false;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  running = false;
  loop.join();
  rig.telemetry->stop();
  for (const Visitor& visitor : visitors) {
    EXPECT_GE(visitor.calls.load(), 200);
    EXPECT_EQ(visitor.calls_while_away.load(), 0);
  }
}

TEST(Telemetry, StopDrainsTheRest) {
  DeviceRig rig;
  std::string diary;
  Diarist listener(diary, "x");
  rig.telemetry->add(0, &listener);
  rig.telemetry->start();
  tick(rig, 50);  // without a bell
  rig.telemetry->stop();
  EXPECT_EQ(
      std::count(diary.begin(), diary.end(), 'x') - std::count(diary.begin(), diary.end(), '!'),
      50);
  rig.telemetry->remove(0, &listener);
}

TEST(Telemetry, OneBellPerTickIsEnough) {
  DeviceRig rig;
  rig.telemetry->start();
  for (std::uint64_t i = 1; i <= 2000; ++i) {
    tick(rig, 1);
    rig.telemetry->bell().ring();
    // The drain must hear of every tick by its one bell, however the two threads interleave.
    while (rig.newest().beat.tick != i) std::this_thread::yield();
  }
  rig.telemetry->stop();
}

}  // namespace
