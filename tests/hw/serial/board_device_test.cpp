/// A board on a pseudo-terminal, in real time: port, I/O thread, emulator.
#include "hw/board/board_device.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <thread>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/emulator/serve.hpp"
#include "hw/simulated/hand.hpp"
#include "tests/support/allocation_guard.hpp"
#include "tests/support/message_of.hpp"
#include "tests/support/temporary_file.hpp"

namespace haptic::hw {
namespace {

using namespace std::chrono_literals;
using emulator::EmulatorConfig;
using emulator::FaultKind;

/// The emulator's board as its thread tells it.
struct Told {
  bool drives{false};
  double reference{0.0};
  hb_state state{HB_DISARMED};
  std::uint32_t watchdog_stops{0};
};

class EmulatorThread {
 public:
  EmulatorThread()
      : board_(EmulatorConfig{}, {Eigen::Vector2d::Zero(), Eigen::Vector2d(0.5, 0.5)},
               core::make_finger_exoskeleton(core::finger_sign_change())),
        terminal_(port()),
        thread_([this] {
          serve(board_, terminal_, stop_, [this](const auto& board) { look(board); });
        }) {}
  ~EmulatorThread() { end(); }
  EmulatorThread(const EmulatorThread&) = delete;
  EmulatorThread& operator=(const EmulatorThread&) = delete;

  void end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  /// After end(): the board's own last word.
  [[nodiscard]] const hb_counters& counters() const { return board_.firmware().counters; }
  [[nodiscard]] std::string port() const { return folder_.path() / "port"; }
  [[nodiscard]] Told told() const {
    const std::lock_guard lock(mutex_);
    return told_;
  }
  /// Makes a fault begin now, for `length` s.
  void fault(FaultKind kind, double length) {
    const std::lock_guard lock(mutex_);
    wanted_fault_ = emulator::FaultSpec{kind, 0.0, length, 0.0};
  }

 private:
  void look(const emulator::EmulatedBoard& board) {
    const std::lock_guard lock(mutex_);
    told_ = {board.drives(), board.reference(), board.firmware().state,
             board.firmware().counters.watchdog_stops};
    if (!wanted_fault_) return;
    wanted_fault_->at = static_cast<double>(board.now_us()) * 1e-6;
    board_.add_fault(*wanted_fault_);
    wanted_fault_.reset();
  }
  test::ScratchFolder folder_{};
  emulator::EmulatedBoard board_;
  emulator::PseudoTerminal terminal_;
  mutable std::mutex mutex_;
  Told told_{};
  std::optional<emulator::FaultSpec> wanted_fault_{};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

BoardConfig config(const std::string& port) {
  BoardConfig c;
  c.port = port;
  c.max_effort = core::VecA::Constant(1, 40.0);
  return c;
}

std::unique_ptr<Device> open(const BoardConfig& c) {
  return c.open(core::make_finger_exoskeleton(core::finger_sign_change()), 20ms);
}

core::TimePoint now() {
  return core::TimePoint(std::chrono::steady_clock::now().time_since_epoch());
}

/// The loop: a tick per millisecond, as long as `until` says no; false after `patience`.
class Loop {
 public:
  explicit Loop(Device& device) : device_(device) { command.tau_a = core::VecA::Zero(1); }

  bool run_until(const std::function<bool()>& until, core::Duration patience = 5s) {
    const core::TimePoint end = now() + patience;
    while (!until()) {
      if (now() > end) return false;
      tick();
      std::this_thread::sleep_for(1ms);
    }
    return true;
  }
  void run(core::Duration length) {
    static_cast<void>(run_until([] { return false; }, length));
  }
  void tick() {
    device_.read(now(), reading);
    device_.write(now(), command);
    if (reading.fresh) ++samples;
  }
  Command command{};
  core::DeviceReading reading{};
  int samples{0};

 private:
  Device& device_;
};

struct OpenBoard : testing::Test {
  EmulatorThread board{};
  std::unique_ptr<Device> device = open(config(board.port()));
  Loop loop{*device};
  bool armed() {
    // The board stops if this machine pauses longer than the watchdog; then it is armed again.
    for (int i = 0; i < 5 && !loop.reading.armed; ++i) {
      loop.command.arm = false;
      loop.tick();
      loop.command.arm = true;
      static_cast<void>(loop.run_until([&] { return loop.reading.armed; }, 1s));
    }
    return loop.reading.armed;
  }
  /// Waits for the board's own state, without ticks.
  void await(const std::function<bool()>& holds) {
    for (int i = 0; i < 1000 && !holds(); ++i) std::this_thread::sleep_for(1ms);
  }
};

TEST_F(OpenBoard, GivesSamplesAndPressesOnceArmed) {
  ASSERT_TRUE(loop.run_until([&] { return loop.samples > 100; }));
  EXPECT_EQ(loop.reading.health, core::DeviceHealth::kOk);
  EXPECT_FALSE(loop.reading.armed);
  EXPECT_EQ(loop.reading.sample.tau_measured.size(), 1);
  EXPECT_EQ(device->info().kind, "board");
  EXPECT_EQ(device->info().serial, "EMULATOR-1");
  EXPECT_EQ(device->info().limits.max_silence, 10ms);
  EXPECT_EQ(device->info().limits.max_effort[0], 40.0);
  ASSERT_TRUE(armed());
  loop.command.tau_a[0] = 4.0;
  EXPECT_TRUE(loop.run_until([&] { return board.told().reference == 4.0; }));
  EXPECT_TRUE(board.told().drives);
  loop.command.arm = false;
  loop.tick();
  loop.tick();
  EXPECT_FALSE(loop.reading.armed) << "disarmed at once, whatever the board has heard yet";
  EXPECT_TRUE(loop.run_until([&] { return board.told().state == HB_DISARMED; }));
}

TEST_F(OpenBoard, ASignalComesWithItsSample) {
  SampleSignal* const samples = device->sample_signal();
  ASSERT_NE(samples, nullptr);
  core::DeviceReading reading;
  int fresh = 0;
  for (int i = 0; i < 300; ++i) {
    const auto arrival = samples->wait_until(now() + 10s);
    ASSERT_TRUE(arrival) << "a board that streams is never silent for so long";
    EXPECT_LE(*arrival, now());
    samples->forget();
    device->read(now(), reading);
    fresh += reading.fresh ? 1 : 0;
    EXPECT_LE(reading.sample.time, now());
  }
  // One that comes between forget() and read() is read at once, and told of all the same.
  EXPECT_GE(fresh, 250);
  const auto other =
      SimulatedHandConfig{}.open(core::make_finger_exoskeleton(core::finger_sign_change()), {});
  EXPECT_EQ(other->sample_signal(), nullptr) << "no clock of its own";
}

TEST_F(OpenBoard, LinkCountsBalance) {
  loop.command.arm = true;
  ASSERT_TRUE(loop.run_until([&] { return loop.samples > 300; }));
  device->close();
  await([&] { return board.told().state == HB_DISARMED; });
  board.end();
  const auto frames = [book = device->link_counts()](const std::string& end,
                                                     const std::string& what) {
    for (const LinkCount& line : book) {
      if (line.end == end && line.what == what) return line.frames;
    }
    ADD_FAILURE() << "no " << end << ' ' << what;
    return std::uint64_t{0};
  };
  EXPECT_GT(frames("host", "received"), 300U);
  EXPECT_LE(frames("host", "lost"), frames("board", "without_room"));
  EXPECT_GT(frames("board", "accepted"), 0U) << "as its COUNTERS told";
  const hb_counters& n = board.counters();
  EXPECT_EQ(frames("host", "sent"),
            n.accepted + n.bad_crc + n.malformed + n.not_newer + n.wrong_nonce);
  const auto other =
      SimulatedHandConfig{}.open(core::make_finger_exoskeleton(core::finger_sign_change()), {});
  EXPECT_TRUE(other->link_counts().empty()) << "no link, no book";
}

TEST_F(OpenBoard, CloseDisarms) {
  ASSERT_TRUE(armed());
  device->close();
  device->close();
  await([&] { return board.told().state == HB_DISARMED; });
  EXPECT_EQ(board.told().state, HB_DISARMED);
  EXPECT_EQ(board.told().watchdog_stops, 0U);
}

TEST_F(OpenBoard, AReplugComesBackDisarmed) {
  ASSERT_TRUE(armed());
  board.fault(FaultKind::kUnplug, 0.5);
  ASSERT_TRUE(loop.run_until([&] { return loop.reading.health == core::DeviceHealth::kLost; }));
  EXPECT_FALSE(loop.reading.armed);
  EXPECT_TRUE(loop.run_until([&] { return !board.told().drives; }));
  ASSERT_TRUE(loop.run_until([&] { return loop.reading.health == core::DeviceHealth::kOk; }));
  loop.run(100ms);
  EXPECT_FALSE(loop.reading.armed) << "an arming does not outlive its link";
  EXPECT_TRUE(armed());
}

TEST_F(OpenBoard, ReadAndWriteAllocateNothing) {
  ASSERT_TRUE(armed());
  for (int i = 0; i < 50; ++i) {
    std::this_thread::sleep_for(1ms);
    const test::AllocationGuard guard;
    loop.tick();
    EXPECT_EQ(guard.allocations() + guard.releases(), 0U);
  }
}

std::string why(const BoardConfig& c) {
  return test::message_of<core::DeviceError>([&] { return open(c); });
}

TEST(BoardDevice, OpensOnlyPortsWithABoard) {
  EmulatorThread board;
  const emulator::PseudoTerminal silent("");
  BoardConfig other = config(board.port());
  other.serial = "HX-0002";
  const struct {
    BoardConfig config;
    const char* says;
  } refused[] = {
      {config("/dev/no-such-port"),
       "/dev/no-such-port: No such file or directory; must be a "
       "serial port (is the board plugged in?)"},
      {config("/dev/null"), "must be a serial port"},
      {other, "board refused: its serial = 'EMULATOR-1': must be 'HX-0002'"},
      {config(silent.port()), "no answer to HELLO in 3000 ms"},
  };
  for (const auto& [config, says] : refused) {
    EXPECT_NE(why(config).find(says), std::string::npos) << why(config);
  }
  const auto first = open(config(board.port()));
  EXPECT_NE(why(config(board.port())).find("in use by another program"), std::string::npos);
}

}  // namespace
}  // namespace haptic::hw
