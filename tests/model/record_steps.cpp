/// Drives the shipped Owner and DeviceUnit on virtual time by random steps, and writes each step
/// and the state after it (steps.h), for the model to replay (README.md).
///
///   haptic_model_steps SEED STEPS FILE

#include <array>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <random>

#include "server/owner/link/from_front.hpp"
#include "tests/model/steps.h"
#include "tests/server/support/device_rig.hpp"

namespace haptic::test {
namespace {

using server::Request;
using server::SessionId;
using Kind = Request::Kind;

constexpr unsigned kSessions = SESSIONS;
constexpr std::size_t kStepsOfRun = 3000;
/// Records that wait at most: more than any request waits for.
constexpr std::size_t kMostLag = server::PendingRequests::kPatience + 100;
static_assert(kMostLag < RECORDS);

/// A device whose faults and answers to "arm" the run decides.
class WilfulDevice final : public hw::Device {
 public:
  [[nodiscard]] const hw::DeviceInfo& info() const noexcept override { return like_.info(); }
  void read(core::TimePoint now, core::DeviceReading& reading) noexcept override {
    like_.lost = cause;
    like_.silent = !present;
    like_.read(now, reading);
    reading.armed = armed;
  }
  void write(core::TimePoint /*now*/, const hw::Command& /*command*/) noexcept override {}
  void close() noexcept override {}

  bool present{false}, cause{false}, armed{false};

 private:
  ScriptedDevice like_;
};

struct Hook final : server::RecordListener {
  explicit Hook(std::function<void(const core::TickRecord&)> what) : act(std::move(what)) {}
  void on_record(const core::TickRecord& record) override { act(record); }
  std::function<void(const core::TickRecord&)> act;
};

core::PipelineConfig config_of(bool calm) {
  core::PipelineConfig config = rig_config();
  // Force fades for longer than any scene allows, so that a newcomer gives up.
  if (calm) config.scene.staleness.fade_end = config.scene.staleness.hold_end + 3s;
  return config;
}

/// One run, from the start of the server until its loop ends or the run is long enough. If it is
/// calm, stops and faults are rare.
class Run final : public server::FrontPort {
 public:
  Run(std::mt19937& random, bool calm) : random_(random), rarely_(calm ? 20 : 1) {
    sigterm_ = random_() % (one_of(4) ? 20 : 2 * kStepsOfRun);
    auto device = std::make_unique<WilfulDevice>();
    device_ = device.get();
    unit_.emplace("rig", std::move(device), config_of(calm));
    telemetry_.emplace(std::vector<server::DeviceUnit*>{&*unit_});
    owner_.emplace(*telemetry_);
    telemetry_->add(0, &before_);
    owner_->add(*unit_, {.lease_timeout = 400ms});
    telemetry_->add(0, &after_);
    owner_->connect(self_);
  }

  std::vector<Step> steps() {
    begin(STEP_RUN);
    while (steps_.size() < kStepsOfRun && unit_->state() != core::LifecycleState::kClosing) {
      any_step();
    }
    telemetry_->drain();
    // The loop's state is known from the record of its tick, and stays until the next one.
    Step loop{};
    loop.state = static_cast<unsigned char>(core::LifecycleState::kInit);
    loop.lost = 1;
    for (Step& step : steps_) {
      if (step.event == STEP_TICK) loop = step;
      step.state = loop.state;
      step.gain = loop.gain;
      step.lost = loop.lost;
      step.stop = loop.stop;
      step.fault = loop.fault;
    }
    return std::move(steps_);
  }

  void on_answer(const server::Answer& answer) override {
    const auto asked = asked_.find(answer.id);
    if (asked == asked_.end()) return;
    const bool no = answer.refusal.has_value();
    const bool late = no && answer.refusal->reason == "NO_ANSWER";
    Step& step = steps_.back();
    switch (asked->second) {
      case Kind::kEngage:
        step.told |= no ? ENGAGE_NO : ENGAGE_YES;
        step.gave_up_engage = late;
        engage_waits_ = false;
        break;
      case Kind::kOpen:
        step.told |= no ? OPEN_NO : OPEN_YES;
        step.gave_up_newcomer = late;
        if (!no) epoch_ = answer.lease.epoch;
        break;
      case Kind::kClear:
        (step.told & (CLEAR_YES | CLEAR_NO) ? step.gave_up_next_clear : step.gave_up_clear) = late;
        step.told |= no ? CLEAR_NO : CLEAR_YES;
        --clears_;
        break;
      default:
        admitted_ = answer.session_id;
    }
  }
  void on_event(std::size_t /*device*/, const server::DeviceEvent& event) override {
    if (event.kind == server::DeviceEvent::Kind::kLeaseExpired) steps_.back().expired = 1;
  }

 private:
  Step& begin(unsigned char event) {
    steps_.emplace_back().event = event;
    return steps_.back();
  }
  void end() {
    const server::DeviceStatus status = owner_->status(0);
    steps_.back().detached = status.detached;
    steps_.back().holder = slot_of(status.holder);
  }
  bool one_of(unsigned n) { return random_() % n == 0; }
  unsigned char slot_of(const SessionId& id) const {
    unsigned char slot = 0;
    while (slot < kSessions && (id.empty() || !(ids_[slot] == id))) ++slot;
    return slot;
  }

  /// The owner is about to read the oldest record.
  void before_drain(const core::TickRecord& record) {
    Step& tick = steps_.at(ticks_.at(drained_++));
    using Verdict = core::EngageVerdict;
    const Verdict verdict = record.life.engage.verdict;
    tick.ready = record.sensed.ready;
    tick.lost = record.proxy.level == core::Staleness::kLost;
    tick.judged = verdict == Verdict::kAccepted || verdict == Verdict::kReleased;
    tick.state = static_cast<unsigned char>(record.life.state);
    tick.gain = record.life.gain > 0.0;
    tick.stop = record.faults().has(core::Fault::kEmergencyStop);
    tick.fault = record.faults().has(core::Fault::kDeviceLost);
    begin(STEP_DRAIN);
  }
  void after_drain(const core::TickRecord& record) {
    end();
    if (one_of(20)) any_call();
    // A newcomer comes while force fades, above all before the tick that ends it.
    if (!front_ || record.life.state != core::LifecycleState::kReleasing) return;
    if (record.life.gain == 0.0 || one_of(20)) open();
  }

  void any_step() {
    if (steps_.size() > sigterm_ && !std::exchange(closing_, true)) return terminate();
    if (random_() % 8 < 5) {
      sample();
      tick();
    } else if (one_of(2) && ticks_.size() - drained_ > lag_) {
      telemetry_->drain();
      lag_ = one_of(60) ? kMostLag - 1 : random_() % 4;
    } else {
      any_call();
    }
  }

  void tick() {
    if (ticks_.size() - drained_ == kMostLag) return;
    Step& step = begin(STEP_TICK);
    device_->present = device_->present || one_of(3);
    device_->cause = one_of(150 * rarely_);
    device_->armed = !one_of(100 * rarely_);
    step.cause = device_->cause;
    step.armed = device_->armed;
    ticks_.push_back(steps_.size() - 1);
    now_ += std::chrono::milliseconds(one_of(100) ? 300 : 1 + random_() % 25);
    unit_->tick(now_, DeviceRig::kTick, {});
    end();
  }

  void sample() {
    if (!front_ || silent_ || one_of(20)) return;
    Step& step = begin(STEP_SAMPLE);
    step.old = one_of(20);
    server::ProxySample sample{.epoch = epoch_ - step.old,
                               .seq = ++seq_,
                               .arrival = now_,
                               .mode = core::ProxyMode::kFree,
                               .position = {0.0, 0.0}};
    if (owner_->accept(sample).used()) step.told = SAMPLE_TAKEN;
    end();
  }

  void any_call() {
    if (quiet_ > 0) return void(--quiet_);
    switch (random_() % 16) {
      case 0:
        return one_of(8 * rarely_) ? post({.kind = Kind::kStop, .local = true}, STEP_LOCAL_STOP)
                                   : void();
      case 1:
      case 2:
        return clear({.kind = Kind::kClear, .local = true}, STEP_LOCAL_CLEAR);
      case 3:
        silent_ = one_of(6);
        return;
      case 4:
        return any_front();
      default:
        return front_ ? from_front() : void();
    }
  }
  void terminate() {
    begin(STEP_SIGTERM);
    owner_->begin_closing();
    end();
  }
  void any_front() {
    if (net_stop_) {
      net_stop_ = false;
      return post({.kind = Kind::kStop}, STEP_STOP);
    }
    if (!front_) {
      begin(STEP_FRONT_STARTS);
      front_ = true;
    } else if (one_of(4 * rarely_)) {
      begin(STEP_FRONT_ASKS_STOP);
      net_stop_ = true;
    } else if (one_of(15)) {
      begin(STEP_FRONT_GONE);
      owner_->front_gone();
      open_ = {};
      front_ = false;
    } else {
      return;
    }
    end();
  }

  void from_front() {
    const unsigned char holder = slot_of(owner_->status(0).holder);
    const bool any = holder == kSessions || one_of(2);
    who_ = any ? static_cast<unsigned char>(random_() % kSessions) : holder;
    const Request by{.session_id = ids_[who_]};
    switch (random_() % 12) {
      case 0:
        return admit();
      case 1:
        return open();
      case 2:
        return one_of(4) ? open() : void();
      case 3:
        return one_of(2) ? close(by, Kind::kClose, STEP_CLOSE) : void();
      case 4:
        return one_of(3) ? close(by, Kind::kLose, STEP_LOSE) : void();
      case 5:
        return one_of(6) ? as(by, Kind::kRelease, STEP_RELEASE) : void();
      case 6:
        return one_of(6) ? cancel() : void();
      case 7:
      case 8:
        return clear({.kind = Kind::kClear}, STEP_CLEAR);
      default:
        return engage_waits_ ? void() : engage(by);
    }
  }
  void as(Request request, Kind kind, unsigned char event) {
    request.kind = kind;
    post(request, event);
  }
  void admit() {
    const unsigned char holder = slot_of(owner_->status(0).holder);
    unsigned slot = 0;
    while (slot < kSessions && (open_[slot] || slot == holder)) ++slot;
    if (slot == kSessions) return;
    post({.kind = Kind::kAdmitSession}, STEP_ADMIT);
    ids_[slot] = admitted_;
    open_[slot] = true;
  }
  void open() {
    who_ = static_cast<unsigned char>(random_() % kSessions);
    if (!open_[who_] && !one_of(8)) return;
    Request request{.kind = Kind::kOpen, .session_id = ids_[who_]};
    const SessionId holder = owner_->status(0).holder;
    Step& step = begin(STEP_OPEN);
    step.high = one_of(4);
    step.keeps = one_of(2);
    step.resumes = !holder.empty() && one_of(2);
    quiet_ = one_of(3) ? static_cast<unsigned>(random_() % 80) : 0;  // a newcomer may wait long
    request.lease = {
        .client_name = "alice",
        .nominal_rate_hz = 1000.0,
        .priority = step.high ? server::Priority::kOperator : server::Priority::kPrimary,
        .resumable = step.keeps != 0,
        .resume = step.resumes ? holder : SessionId{}};
    post(request);
  }
  void close(const Request& by, Kind kind, unsigned char event) {
    open_[who_] = false;
    as(by, kind, event);
  }
  void engage(const Request& by) {
    engage_waits_ = true;
    if (open_[who_] && slot_of(owner_->status(0).holder) == who_) engage_ = last_id_ + 1;
    as(by, Kind::kEngage, STEP_ENGAGE);
    // A newcomer's, while the force of the last fades.
    if (unit_->state() == core::LifecycleState::kReleasing && one_of(10)) sigterm_ = 0;
  }
  void cancel() {
    if (engage_ == 0) return;
    begin(STEP_CANCEL);
    engage_waits_ = false;
    owner_->post({.id = engage_, .kind = Kind::kCancel});
    end();
  }
  void clear(Request request, unsigned char event) {
    if (clears_ == 2) return;
    ++clears_;
    Step& step = begin(event);
    step.all = one_of(2);
    if (!step.all) request.faults.set(core::Fault::kDeviceLost);
    post(request);
    if (one_of(3)) clear({.kind = Kind::kClear, .local = request.local}, event);
  }
  void post(const Request& request, unsigned char event) {
    begin(event);
    post(request);
  }
  /// The step has begun. A front claims that its request is local.
  void post(Request request) {
    request.id = ++last_id_;
    if (!request.local) {
      request.local = true;
      if (!server::make_harmless(request, now_)) std::abort();
    }
    steps_.back().who = who_;
    if (request.kind != Kind::kStop && request.kind != Kind::kRelease) {
      asked_[request.id] = request.kind;
    }
    owner_->post(request);
    end();
  }

  std::mt19937& random_;
  const unsigned rarely_;
  std::size_t sigterm_{0};  ///< the step before it
  std::shared_ptr<FrontPort> self_{this, [](auto*) {}};
  Hook before_{[this](const auto& record) { before_drain(record); }};
  Hook after_{[this](const auto& record) { after_drain(record); }};
  WilfulDevice* device_{nullptr};
  std::optional<server::DeviceUnit> unit_{};
  std::optional<server::Telemetry> telemetry_{};
  std::optional<server::Owner> owner_{};
  core::TimePoint now_{1h};
  std::vector<Step> steps_{};
  std::vector<std::size_t> ticks_{};  ///< their steps
  std::size_t drained_{0}, lag_{0};
  bool closing_{false}, front_{false}, net_stop_{false}, silent_{false};
  unsigned quiet_{0};  ///< calls that are not made
  unsigned char who_{0};
  std::array<SessionId, kSessions> ids_{};
  std::array<bool, kSessions> open_{};
  SessionId admitted_{};
  std::map<std::uint64_t, Kind> asked_{};
  std::uint64_t last_id_{0}, engage_{0}, seq_{0};
  bool engage_waits_{false};
  int clears_{0};
  std::uint32_t epoch_{0};
};

}  // namespace
}  // namespace haptic::test

int main(int count, char** arguments) {
  if (count != 4) {
    std::cerr << "haptic_model_steps SEED STEPS FILE\n";
    return 2;
  }
  std::mt19937 random(static_cast<unsigned>(std::atoi(arguments[1])));
  std::ofstream file(arguments[3], std::ios::binary);
  for (long left = std::atol(arguments[2]); left > 0;) {
    const std::vector<Step> steps = haptic::test::Run(random, random() % 3 == 0).steps();
    file.write(reinterpret_cast<const char*>(steps.data()),
               static_cast<std::streamsize>(steps.size() * sizeof(Step)));
    left -= static_cast<long>(steps.size());
  }
  return file.good() ? 0 : 1;
}
