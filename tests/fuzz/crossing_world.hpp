#pragma once
/// An owner with one device, which has a tracked palm and an actuated slide, and a front's sockets,
/// for crossing_target.cpp.

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "haptic/core/model/linear.hpp"
#include "server/crossing/link_messages.hpp"
#include "server/owner/link/front_requests.hpp"
#include "server/owner/link/sample_intake.hpp"
#include "tests/fuzz/targets.hpp"

namespace haptic::test::crossing {

using namespace server;

inline constexpr unsigned kPlaces = 2;  ///< for sessions of each kind
inline constexpr int kDofs = 7;         ///< a tracked palm's six, and the actuated one

inline core::PipelineConfig palm_and_slide() {
  core::LinearMap map{.A = core::MatXQ::Identity(kDofs, kDofs), .x_0 = core::VecX::Zero(kDofs)};
  for (const char* name : {"palm.x", "palm.y", "palm.z", "palm.rx", "palm.ry", "palm.rz", "a"}) {
    map.dofs.push_back({name, core::Unit::kMetre, *name == 'a', -0.8, 0.8});
    map.coordinates.push_back({name, core::Unit::kMetre, core::CoordinateKind::kLinear});
  }
  core::PipelineConfig config{.kinematics = core::make_linear(map)};
  config.device.q_lower = core::VecQ::Constant(kDofs, -1.0);
  config.device.q_upper = core::VecQ::Constant(kDofs, 1.0);
  config.device.max_effort = core::VecA::Constant(1, 20.0);
  config.scene.stiffness = core::VecA::Constant(1, 100.0);
  config.scene.damping = core::VecA::Constant(1, 1.0);
  config.scene.force_limit = core::VecA::Constant(1, 10.0);
  config.scene.slew_limit = core::VecA::Constant(1, 1000.0);
  config.scene.engage_window = core::VecA::Constant(1, 2.5);
  config.tracker = core::TrackerSettings{0, {}};
  return config;
}

class NoDevice final : public hw::Device {
 public:
  [[nodiscard]] const hw::DeviceInfo& info() const noexcept override { return info_; }
  void read(core::TimePoint /*now*/, core::DeviceReading& /*reading*/) noexcept override {}
  void write(core::TimePoint /*now*/, const hw::Command& /*command*/) noexcept override {}
  void close() noexcept override {}

 private:
  hw::DeviceInfo info_{};
};

/// An input is a row of steps, each: one byte what, then its operands. A patch is a count (modulo
/// 8) and as many places (2 bytes), sizes (1 byte) and bytes that are written over a value.
enum FrontStep : std::uint8_t {
  kSample,   ///< an honest sample of the proxy, patched and sent
  kPose,     ///< an honest pose, patched
  kRequest,  ///< kind, whose (an index), device or what to resume; the message is patched and sent
  kStop,     ///< device: ahead of its request
  kJunk,     ///< on which socket, size (2 bytes), bytes: a message
  kTurn,     ///< microseconds (3 bytes): the owner reads
  kTick,     ///< how many ticks, state, what the loop answers
  kSteps
};

/// Inputs that go deep (crossing_seeds.cpp).
[[nodiscard]] std::vector<FuzzBytes> seeds();

/// A sample that an honest client sends, but for the times and numbers.
inline const ProxySample kHonest{.mode = core::ProxyMode::kHeld,
                                 .position = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7}};

/// Parts that are too slow to be made for every input, and are the same at the beginning of each.
struct World {
  World() {
    begin();
    publisher = std::make_shared<Publisher>(*owner, [](const Answer&) {});
    read_pages = SharedMemory(publisher->memory().for_reader(), OwnersPages::bytes(1));
  }

  void begin() {
    std::string description;
    if (owner) description = owner->devices().front().description;
    owner.emplace(telemetry, kPlaces);
    owner->add(unit, {}, description);
    if (publisher) {
      owner->connect(publisher);
      publisher->forget_answers();
    }
    for (const auto& socket : {&front.link, &front.samples}) {
      while (look_at_next(socket->get()).what == Received::kMessage) {
        static_cast<void>(take_bytes(socket->get(), {}));
      }
    }
    front.stops.clear();
    static_cast<void>(unit.proxies.take());
    static_cast<void>(unit.poses.take());
    static_cast<void>(unit.commands.take());
  }

  DeviceUnit unit{"fuzz", std::make_unique<NoDevice>(), palm_and_slide()};
  Telemetry telemetry{{&unit}};
  std::optional<Owner> owner{};
  std::shared_ptr<Publisher> publisher{};
  SharedMemory read_pages{};
  FrontProcess front{1, core::TimePoint{}};
  ProxySample sample{kHonest};
  std::vector<std::pair<std::size_t, std::size_t>> patched{};  ///< places and sizes in the sample
  FrontMessage message{};
};

}  // namespace haptic::test::crossing
