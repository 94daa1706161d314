// The whole server, its loop paced by an emulated board on a pseudo-terminal, in real time.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <thread>

#include "haptic/core/error.hpp"
#include "haptic/core/model/finger_exoskeleton.hpp"
#include "hw/emulator/serve.hpp"
#include "tests/server/support/app.hpp"
#include "tests/server/support/live_server.hpp"
#include "tests/server/support/test_client.hpp"
#include "tests/support/temporary_file.hpp"

namespace {

using namespace std::chrono_literals;
using haptic::core::Fault;
using haptic::hw::emulator::EmulatorConfig;
using haptic::hw::emulator::FaultKind;
using haptic::server::LoopFacts;
using haptic::server::RealtimeMode;
using haptic::test::App;
using haptic::test::eventually;
using testing::HasSubstr;

constexpr haptic::server::AppOptions kNotRealtime{RealtimeMode::kOff};

class BoardThread {
 public:
  explicit BoardThread(const EmulatorConfig& config = {})
      : board_(config, {Eigen::Vector2d::Zero(), Eigen::Vector2d(0.5, 0.5)},
               haptic::core::make_finger_exoskeleton({})),
        terminal_(port()),
        thread_([this] {
          serve(board_, terminal_, stop_, [this](const auto&) { unplug_where_wanted(); });
        }) {}
  ~BoardThread() {
    stop_ = true;
    thread_.join();
  }
  BoardThread(const BoardThread&) = delete;
  BoardThread& operator=(const BoardThread&) = delete;

  [[nodiscard]] std::string port() const { return folder_.path() / "port"; }
  /// From now on, for so many seconds.
  void unplug(double length) { unplug_for_ = length; }

 private:
  void unplug_where_wanted() {
    const double length = unplug_for_.exchange(0.0);
    if (length <= 0.0) return;
    board_.add_fault(
        {FaultKind::kUnplug, static_cast<double>(board_.now_us()) * 1e-6, length, 0.0});
  }
  haptic::test::ScratchFolder folder_{};
  haptic::hw::emulator::EmulatedBoard board_;
  haptic::hw::emulator::PseudoTerminal terminal_;
  std::atomic<double> unplug_for_{0.0};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

haptic::server::Scene paced(const BoardThread& board) {
  haptic::server::Scene scene = haptic::server::load_scene(
      std::string(HAPTIC_SOURCE_DIR) + "/server/scenes/finger_board.textproto",
      {"device[0].board.port=" + board.port(), "loop.paced_by=finger",
       "server.listen[0]=127.0.0.1:0", "loop.late_bucket_full=1000000"});
  scene.server.metrics_listen = "127.0.0.1:0";
  return scene;
}

/// Answer to a scrape of the metrics at `port` of this host.
std::string scraped(std::uint16_t port) {
  const int handle = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string page;
  const std::string request = "GET /metrics HTTP/1.1\r\nHost: here\r\nConnection: close\r\n\r\n";
  if (::connect(handle, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0 &&
      ::send(handle, request.data(), request.size(), 0) == static_cast<ssize_t>(request.size())) {
    std::array<char, 4096> part{};
    for (ssize_t n = 1; n > 0;) {
      n = ::recv(handle, part.data(), part.size(), 0);
      if (n > 0) page.append(part.data(), static_cast<std::size_t>(n));
    }
  }
  ::close(handle);
  return page;
}

TEST(PacedApp, BoardsSamplesOrTheTimerTick) {
  BoardThread board;
  App app(paced(board), kNotRealtime);
  app.start();
  const auto facts = [&app] { return app.loop_facts(); };
  EXPECT_EQ(facts().paced_by, "finger");
  ASSERT_TRUE(eventually([&] { return facts().paced_by_sample > 500; }));
  // A pause of this machine may be a fault already: DEVICE_SILENT, LOOP_LATE.
  EXPECT_FALSE(app.owner().status(0).faults.has(Fault::kDeviceLost));

  // Gone: whatever a busy machine does, no sample can begin a tick now, and ticks go on.
  board.unplug(1.0);
  ASSERT_TRUE(eventually([&] { return app.owner().status(0).faults.has(Fault::kDeviceLost); }));
  const LoopFacts lost = facts();
  ASSERT_TRUE(eventually([&] { return facts().ticks > lost.ticks + 200; }));
  EXPECT_LE(facts().paced_by_sample, lost.paced_by_sample + 1) << "one that was on its way";

  // Back: its samples begin them again, without anybody's help.
  ASSERT_TRUE(eventually([&] { return facts().paced_by_sample > lost.paced_by_sample + 300; }));
  EXPECT_GT(facts().ticks, facts().paced_by_sample);
}

TEST(PacedApp, ReportsThePacingDeviceAndRate) {
  BoardThread board;
  App app(paced(board), kNotRealtime);
  app.start();
  ASSERT_TRUE(eventually([&] { return app.loop_facts().paced_by_sample > 50; }));
  const auto stub = haptic::v1::HapticService::NewStub(
      grpc::CreateChannel(app.addresses().front(), grpc::InsecureChannelCredentials()));
  haptic::v1::GetServerInfoResponse info;
  grpc::ClientContext context;
  ASSERT_TRUE(stub->GetServerInfo(&context, {}, &info).ok());
  EXPECT_EQ(info.loop().paced_by(), "finger");
  EXPECT_GT(info.loop().paced_by_sample(), 50u);
  EXPECT_LE(info.loop().paced_by_sample(), info.loop().ticks());
  EXPECT_THAT(scraped(haptic::test::port_of(app.addresses().back())),
              HasSubstr("haptic_loop_sample_paced_ticks_total{device=\"finger\"} "));
}

TEST(PacedApp, RefusesABoardOfAnotherPeriod) {
  BoardThread board;
  haptic::server::Scene scene = paced(board);
  scene.loop.period = 2ms;
  App app(std::move(scene), kNotRealtime);
  try {
    app.start();
    FAIL() << "must throw";
  } catch (const haptic::core::DeviceError& error) {
    EXPECT_THAT(error.what(), HasSubstr("loop.paced_by = \"finger\""));
    EXPECT_THAT(error.what(), HasSubstr("a sample every 1 ms; must be loop.period, 2 ms"));
  }
}

}  // namespace
