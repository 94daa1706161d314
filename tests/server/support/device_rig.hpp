#pragma once
/// A device with its unit, telemetry, owner and a HandFront; the test ticks it on virtual time. The
/// map is the identity (x = q, two coordinates) and the spring has 100 N/m, so that a force is 100
/// times a proxy's first coordinate.

#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "haptic/core/model/linear.hpp"
#include "server/owner/loop/device_unit.hpp"
#include "server/owner/rights/owner.hpp"
#include "server/owner/telemetry/telemetry.hpp"
#include "tests/server/support/hand_front.hpp"
#include "tests/server/support/scripted_device.hpp"

namespace haptic::test {

using namespace std::chrono_literals;

inline core::PipelineConfig rig_config() {
  core::LinearMap map{.dofs = ScriptedDevice::dofs(),
                      .coordinates = {{"a", core::Unit::kMetre, core::CoordinateKind::kLinear},
                                      {"b", core::Unit::kMetre, core::CoordinateKind::kLinear}},
                      .A = core::MatXQ::Identity(2, 2),
                      .x_0 = core::VecX::Zero(2)};
  core::PipelineConfig config{.kinematics = core::make_linear(map),
                              .device = ScriptedDevice().info().limits};
  config.scene.stiffness = core::VecA::Constant(1, 100.0);
  config.scene.damping = core::VecA::Constant(1, 1.0);
  config.scene.force_limit = core::VecA::Constant(1, 10.0);
  config.scene.slew_limit = core::VecA::Constant(1, 1000.0);
  config.scene.engage_window = core::VecA::Constant(1, 2.5);
  return config;
}

class DeviceRig {
 public:
  static constexpr core::Duration kTick = 1ms;

  explicit DeviceRig(core::PipelineConfig config = rig_config(), server::SessionRules rules = {},
                     core::TimePoint start = core::TimePoint(1h), unsigned max_sessions = 32) {
    auto owned = std::make_unique<ScriptedDevice>();
    device = owned.get();
    unit = std::make_unique<server::DeviceUnit>("rig", std::move(owned), std::move(config));
    telemetry = std::make_unique<server::Telemetry>(std::vector<server::DeviceUnit*>{unit.get()});
    owner = std::make_unique<server::Owner>(*telemetry, max_sessions);
    telemetry->add(0, &newest_);  // first: who hears from the owner of a tick finds its record here
    owner->add(*unit, rules);
    sessions = HandFront::of(*owner);
    now = start;
  }

  void tick(int n = 1) {
    for (int i = 0; i < n; ++i) {
      now += kTick;
      unit->tick(now, kTick, {});
      telemetry->drain();
    }
  }

  [[nodiscard]] core::TickRecord newest() const {
    const std::lock_guard lock(newest_.mutex);
    return newest_.record;
  }
  [[nodiscard]] core::LifecycleState state() const { return newest().life.state; }

  struct Reply {
    std::optional<server::Lease> lease{};
    std::optional<server::Refusal> refusal{};
  };
  /// Asks for the lease; the reply is empty while the request is open.
  std::shared_ptr<Reply> ask(const server::LeaseRequest& wanted) {
    auto reply = std::make_shared<Reply>();
    sessions->open_controller(wanted, now, [reply](const server::Outcome<server::Lease>& outcome) {
      reply->lease = outcome.value;
      if (!outcome) reply->refusal = outcome.refusal;
    });
    return reply;
  }

  /// Opens a controller of 1 kHz and ticks until it is answered and the device armed.
  server::Lease control(const std::string& id = "s1", const std::string& client = "alice") {
    server::LeaseRequest request{
        .session_id = id, .client_name = client, .nominal_rate_hz = 1000.0};
    const auto reply = ask(request);
    const auto armed = [this] { return state() == core::LifecycleState::kArmed; };
    for (int i = 0; i < 400 && !(reply->lease && armed()); ++i) tick();
    const auto lease = reply->lease.value_or(server::Lease{});
    epoch = lease.epoch;
    return lease;
  }

  /// Held; the first one under an epoch is free, because the probe comes from outside.
  server::IngressVerdict publish(double a, double b = 0.0) {
    const bool outside = std::exchange(free_epoch, epoch) != epoch;
    server::ProxySample sample{.epoch = epoch,
                               .seq = ++seq,
                               .arrival = now,
                               .mode = outside ? core::ProxyMode::kFree : core::ProxyMode::kHeld,
                               .position = {a, b}};
    return owner->accept(sample).verdict;
  }

  /// One sample per tick.
  void stream(int ticks, double a) {
    for (int i = 0; i < ticks; ++i) {
      publish(a);
      tick();
    }
  }

  /// Asks for force and ticks once; the refusal's reason, empty if force was granted.
  std::string engage(const std::string& id = "s1") {
    std::string reason = "(no answer)";
    sessions->engage(id, [&](const Outcome<Done>& outcome) {
      reason = outcome ? "" : outcome.refusal.reason.str();
      refusal = outcome.refusal.message.str();
    });
    tick();
    return reason;
  }

  /// Streams until force of 1 N is fully on.
  void press(const std::string& id = "s1") {
    stream(250, 0.01);
    engage(id);
    stream(250, 0.01);
  }

  ScriptedDevice* device{nullptr};
  std::unique_ptr<server::DeviceUnit> unit;
  std::unique_ptr<server::Telemetry> telemetry;
  std::unique_ptr<server::Owner> owner;
  std::shared_ptr<HandFront> sessions;
  core::TimePoint now{};
  std::uint32_t epoch{0};
  std::uint64_t seq{0};
  std::uint32_t free_epoch{0};  ///< had its free sample
  std::string refusal;          ///< sentence of the last engage()

 private:
  struct Newest final : server::RecordListener {
    void on_record(const core::TickRecord& newest) override {
      const std::lock_guard lock(mutex);
      record = newest;
    }
    mutable std::mutex mutex;
    core::TickRecord record{};
  } newest_{};
};

/// The reasons of every event that waits in a queue.
inline std::vector<std::string> reasons(server::EventQueue& queue) {
  std::vector<std::string> all;
  while (auto event = queue.pop()) all.push_back(event->reason.str());
  return all;
}

}  // namespace haptic::test
