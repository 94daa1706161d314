#include "server/owner/rights/owner.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "haptic/core/error.hpp"
#include "server/owner/state/device_message.hpp"

namespace haptic::server {
namespace {

Refusal no_such_session() {
  return {Refusal::Code::kPermission, "NOT_CONTROLLER", "session_id: no such session is open"};
}

bool admits(Request::Kind kind) {
  return kind == Request::Kind::kAdmitSession || kind == Request::Kind::kAdmitObserver ||
         kind == Request::Kind::kAdmitWatch;
}

bool names_device(Request::Kind kind) {
  return admits(kind) || kind == Request::Kind::kStop || kind == Request::Kind::kClear;
}

}  // namespace

/// A device's place at the telemetry.
class Owner::Device final : public RecordListener {
 public:
  Device(Owner& owner, std::size_t place, DeviceUnit& device, const SessionRules& rules)
      : index(place), unit(device), sessions(device, rules), owner_(owner) {
    owner_.telemetry_.add(index, this);
  }
  ~Device() override { owner_.telemetry_.remove(index, this); }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  void on_record(const core::TickRecord& record) override {
    tell_wrong_size(record.input.device.sample.q.size());
    owner_.on_record(*this, record);
  }
  void on_newest(const core::TickRecord& record) override {
    serialise(record, state, serialised_);
    for (const auto& front : owner_.fronts()) front->on_newest(index, serialised_);
  }

  /// Idle processors and, at the end of a tick, the drain stay awake while a connected controller
  /// feels the wake-up.
  void watch_while_controlled() {
    const bool controlled = sessions.lease().has_holder && !sessions.lease().detached;
    if (controlled == std::exchange(watched_, controlled)) return;
    owner_.telemetry_.watch(controlled ? 1 : -1);
  }

  const std::size_t index;
  DeviceUnit& unit;
  DeviceSessions sessions;
  core::TimePoint told_at{};  ///< of the newest event
  v1::DeviceState state{};    ///< of the newest record; the drain's

 private:
  /// Once: the device stays INIT, because no fault names a sample that cannot be one.
  void tell_wrong_size(Eigen::Index size) {
    const auto expected = static_cast<Eigen::Index>(unit.device().info().dofs.size());
    if (size == 0 || size == expected || std::exchange(told_, true)) return;
    spdlog::error("{}: the device's sample is refused: q has {} values, must have {}, one per DoF",
                  unit.name(), size, expected);
  }

  Owner& owner_;
  SerialisedState serialised_{};
  bool watched_{false};
  bool told_{false};  ///< that a sample has the wrong size
};

Owner::Owner(Telemetry& telemetry, unsigned max_sessions)
    : telemetry_(telemetry), registry_(max_sessions) {}

Owner::~Owner() = default;

void Owner::add(DeviceUnit& unit, const SessionRules& rules, std::string description) {
  if (description.empty()) {
    description = describe(unit.name(), unit.device().info(), unit.config()).SerializeAsString();
  }
  const std::size_t largest = largest_state(unit.config());
  if (largest > SerialisedState::kMost) {
    throw core::SceneError("device '" + unit.name() + "': its state may have " +
                           std::to_string(largest) + " bytes, must have at most " +
                           std::to_string(SerialisedState::kMost));
  }
  facts_.push_back({unit.name(), std::move(description), unit.config().scene.staleness,
                    rules.lease_timeout, largest});
  devices_.push_back(std::make_unique<Device>(*this, devices_.size(), unit, rules));
}

template <typename Act>
void Owner::serve(const Act& act) {
  const Fronts fronts = this->fronts();
  std::vector<Answer> answers;
  {
    const std::lock_guard lock(mutex_);
    act(answers);
    for (const auto& device : devices_) {
      device->watch_while_controlled();
      Outbox out = device->sessions.take();
      for (DeviceEvent& event : out.events) {
        // No two have one time: by it a client says up to which event it knows them.
        event.time = std::max(event.time, device->told_at + core::Duration(1));
        device->told_at = event.time;
        for (const auto& front : fronts) front->on_event(device->index, event);
      }
      answers.insert(answers.end(), out.answers.begin(), out.answers.end());
    }
  }
  for (const Answer& answer : answers) {
    for (const auto& front : fronts) front->on_answer(answer);
  }
}

void Owner::begin_closing() {
  serve([this](auto&) {
    for (const auto& device : devices_) device->sessions.begin_closing();
  });
}

void Owner::loop_ended() {
  serve([this](auto&) {
    for (const auto& device : devices_) device->sessions.loop_ended();
  });
}

void Owner::front_gone() {
  serve([this](std::vector<Answer>& answers) {
    for (const auto& [id, kind] : registry_.all()) {
      const bool watch = kind == Request::Kind::kAdmitWatch;
      handle({.kind = watch ? Request::Kind::kClose : Request::Kind::kLose, .session_id = id},
             answers);
    }
  });
}

void Owner::post(const Request& request) {
  serve([&](std::vector<Answer>& answers) { handle(request, answers); });
}

void Owner::handle(const Request& request, std::vector<Answer>& answers) {
  using Kind = Request::Kind;
  if (request.kind == Kind::kCancel) {
    for (const auto& device : devices_) device->sessions.handle(request);
    return;
  }
  std::optional<std::size_t> device = request.device;
  if (!names_device(request.kind)) device = registry_.device_of(request.session_id);
  const bool ending = request.kind == Kind::kClose || request.kind == Kind::kLose;
  if (!device || *device >= devices_.size()) {
    if (!ending) answers.emplace_back(Answer{request.id, no_such_session()});
    return;
  }
  DeviceSessions& sessions = devices_[*device]->sessions;
  if (admits(request.kind)) {
    const auto id =
        registry_.admit(request.kind, *device, sessions.would_resume(request.session_id));
    Answer& answer = answers.emplace_back(Answer{request.id});
    if (id) {
      answer.session_id = *id.value;
    } else {
      answer.refusal = id.refusal;
    }
    return;
  }
  sessions.handle(request);
  if (ending) registry_.remove(request.session_id);
}

Verdict Owner::accept(const ProxySample& sample) {
  const std::lock_guard lock(mutex_);
  return devices_.at(sample.device)->sessions.accept(sample);
}

Verdict Owner::accept(const PoseSample& pose) {
  const std::lock_guard lock(mutex_);
  return devices_.at(pose.device)->sessions.accept(pose);
}

void Owner::post(const ProxySample& sample) {
  tell({sample.ticket, sample.seq, sample.carrier, accept(sample)});
}

void Owner::post(const PoseSample& pose) {
  tell({pose.ticket, pose.seq, Carrier::kGrpc, accept(pose)});
}

void Owner::tell(const Judged& judged) {
  for (const auto& front : fronts()) front->on_judged(judged);
}

DeviceStatus Owner::status(std::size_t device) const {
  const std::vector<hw::LinkCount> counts = devices_.at(device)->unit.device().link_counts();
  const std::lock_guard lock(mutex_);
  DeviceStatus status = devices_[device]->sessions.status();
  for (const hw::LinkCount& n : counts) {
    if (status.link_count == status.link.size()) break;
    status.link[status.link_count++] = {n.end, n.what, n.frames};
  }
  status.sessions = registry_.count(Request::Kind::kAdmitSession, device) +
                    registry_.count(Request::Kind::kAdmitObserver, device);
  const bool holder_listens = registry_.device_of(status.holder).has_value();
  status.observers = status.sessions + registry_.count(Request::Kind::kAdmitWatch, device) -
                     (holder_listens ? 1U : 0U);
  return status;
}

const v1::DeviceState& Owner::newest(std::size_t device) const {
  return devices_.at(device)->state;
}

void Owner::on_record(Device& device, const core::TickRecord& record) {
  std::optional<TickTold> told;
  serve([&](auto&) {
    device.sessions.step(record);
    told.emplace(device.sessions.told(record));
  });
  write(*told, device.state);
  if (metrics_) metrics_->count(device.index, *told);
}

}  // namespace haptic::server
