#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "server/base/steady_now.hpp"
#include "tests/fuzz/crossing_world.hpp"
#include "tests/fuzz/targets.hpp"

namespace haptic::test {
namespace crossing {
namespace {

using namespace std::chrono_literals;

/// Calls `patched` with what it has written over, if that is wanted.
template <typename T, typename Patched = void (*)(std::size_t, std::size_t)>
void patch(
    T& value, FuzzReader& reader, const Patched& patched = [](std::size_t, std::size_t) {}) {
  for (int n = reader.byte() % 8; n > 0; --n) {
    const std::size_t at = reader.number(2) % sizeof(T);
    const FuzzInput bytes = reader.take(reader.byte());
    const std::size_t size = std::min(bytes.size(), sizeof(T) - at);
    std::memcpy(reinterpret_cast<std::uint8_t*>(&value) + at, bytes.data(), size);
    patched(at, size);
  }
}

class Crossing {
 public:
  Crossing() { world_.begin(); }

  std::string run(FuzzInput input) {
    FuzzReader reader(input);
    while (!reader.empty() && finding_.empty()) step(reader);
    if (finding_.empty()) be_honest();
    return finding_;
  }

 private:
  static World& world() {
    static World world;
    return world;
  }

  void step(FuzzReader& reader) {
    switch (static_cast<FrontStep>(reader.byte() % kSteps)) {
      case kSample: {
        ProxySample& sample = honest_sample();
        patch(sample, reader,
              [this](std::size_t at, std::size_t size) { world_.patched.emplace_back(at, size); });
        return push(SampleKind::kProxy, sample);
      }
      case kPose: {
        PoseSample pose{.session_id = whose(reader.byte()),
                        .seq = ++seq_,
                        .arrival = now_,
                        .position = {0.1, 0.2, 0.3},
                        .orientation = {0.0, 0.0, 0.0, 1.0}};
        patch(pose, reader);
        return push(SampleKind::kPose, pose);
      }
      case kRequest: {
        const auto kind = static_cast<Request::Kind>(reader.byte());
        FrontMessage message = asks(kind, whose(reader.byte()));
        const std::uint8_t what = reader.byte();
        message.request.device = what / 128U;
        if (what % 2 != 0) message.request.lease.resume = whose(what / 2);
        patch(message, reader);
        sent_ += send(world_.front.its_link.get(), message) ? 1 : 0;
        return;
      }
      case kStop:
        return push(SampleKind::kStopAhead, StopAhead{reader.byte(), "fuzz"});
      case kJunk: {
        const bool requests = reader.byte() % 2 == 0;
        const FuzzInput bytes = reader.take(reader.number(2) % 4096);
        if (bytes.empty()) return;
        const Descriptor& socket = requests ? world_.front.its_link : world_.front.its_samples;
        sent_ += send_bytes(socket.get(), std::as_bytes(bytes)) && requests ? 1 : 0;
        return;
      }
      case kTurn:
        now_ += std::chrono::microseconds(reader.number(3));
        return turn();
      default: {
        const int ticks = 1 + reader.byte() % 4;
        const std::uint8_t state = reader.byte();
        return tick(ticks, state, reader.byte());
      }
    }
  }

  ProxySample& honest_sample() {
    ProxySample& sample = world_.sample;
    for (const auto& [at, size] : world_.patched) {
      std::memcpy(reinterpret_cast<std::uint8_t*>(&sample) + at,
                  reinterpret_cast<const std::uint8_t*>(&kHonest) + at, size);
    }
    world_.patched.clear();
    sample.epoch = epoch_;
    sample.seq = ++seq_;
    sample.arrival = now_;
    return sample;
  }
  [[nodiscard]] SessionId whose(std::uint8_t index) const {
    return ids_.empty() ? SessionId{} : ids_[index % ids_.size()];
  }
  FrontMessage asks(Request::Kind kind, const SessionId& session) {
    FrontMessage message{.kind = FrontMessage::Kind::kRequest};
    message.request = {.id = ++id_, .kind = kind, .session_id = session};
    message.request.lease = {.client_name = "a", .nominal_rate_hz = 100.0, .resumable = true};
    return message;
  }

  template <typename T>
  void push(SampleKind kind, const T& value) {
    send_sample(world_.front.its_samples.get(), kind, value);
  }

  /// Does what FrontLink::turn() does, and does not end a front that sends junk: takes it away.
  void turn() {
    if (!intake_.take(world_.front)) {
      static_cast<void>(take_bytes(world_.front.samples.get(), {}));
    }
    FrontMessage& message = world_.message;
    for (; sent_ > 0; --sent_) {
      const Received got = receive(world_.front.link.get(), message);
      if (got == Received::kNothing) fail("a message is lost");
      if (message.text.view().size() > 512) finding_ = "a text is too long";
      if (got != Received::kMessage || message.kind != FrontMessage::Kind::kRequest) continue;
      requests_.post(world_.front, message.request, now_);
    }
    requests_.take_stops(world_.front, now_);
    look();
    const DeviceStatus status = world_.owner->status(0);
    // Those who resume have as many places again.
    if (status.observers > 6 * kPlaces || status.sessions > 4 * kPlaces) {
      fail("more sessions than there are places");
    }
  }

  /// Does what the loop does: takes what is in the mailboxes, and answers it if bit 0 of `says` is
  /// set.
  void tick(int ticks, std::uint8_t state, std::uint8_t says) {
    for (; ticks > 0; --ticks) {
      now_ += 1ms;
      const core::CommandSnapshot& command = world_.unit.commands.value();
      ++record_.beat.tick;
      record_.input.now = now_;
      record_.input.command = began_ ? command : core::CommandSnapshot{};
      record_.input.settings = world_.unit.settings.value();
      if (newest_seq_ != 0) {
        const core::ProxySnapshot& proxy = world_.unit.proxies.value();
        record_.proxy.mode = proxy.mode;
        record_.proxy.seq = proxy.seq;
        record_.proxy.age = now_ - proxy.born;
      }
      core::Lifecycle& life = record_.life;
      life.state = static_cast<core::LifecycleState>(1 + state % 8);
      life.gain = (says & 2U) != 0 ? 0.5 : 0.0;
      if ((says & 1U) != 0) {
        life.engage.id = record_.input.command.engage_id;
        life.engage.verdict = static_cast<core::EngageVerdict>(1 + (says >> 2U) % 9);
        life.release_id = record_.input.command.release_id;
        life.stop_id = record_.input.command.stop_id;
        life.clear.id = record_.input.command.clear_id;
      }
      life.faults = core::FaultSet((says & 4U) != 0 ? 0x80U : 0U);
      world_.unit.records.prepare([this] { return record_; });
      world_.unit.records.push();
      world_.telemetry.drain();
    }
    look();
  }

  /// After all that: what was sent is read in a bounded number of turns, and an honest client gets
  /// the lease, and its sample through.
  void be_honest() {
    for (int turns = 0; look_at_next(world_.front.samples.get()).what != Received::kNothing;) {
      turn();
      if (++turns > 2000) finding_ = "the reading does not end";
      if (!finding_.empty()) return;
    }
    world_.owner->front_gone();
    world_.publisher->forget_answers();
    look();
    ids_.clear();
    id_ = 1U << 20U;
    ask(asks(Request::Kind::kAdmitSession, {}));
    if (ids_.empty()) return fail("an honest client is not admitted");
    FrontMessage open = asks(Request::Kind::kOpen, ids_.front());
    open.request.lease.priority = Priority::kOperator;
    epoch_ = 0;
    ask(open);
    for (int i = 0; i < 4 && epoch_ == 0; ++i) tick(1, 2, 1);
    if (epoch_ == 0) return fail("an honest client gets no lease");
    const auto accepted = [&] {
      return world_.owner->status(0).samples[IngressVerdict::kAccepted];
    };
    const std::uint64_t before = accepted();
    seq_ = 0;
    push(SampleKind::kProxy, honest_sample());
    turn();
    if (accepted() != before + 1) fail("an honest sample does not get through");
  }
  void ask(const FrontMessage& message) {
    if (!send(world_.front.its_link.get(), message)) fail("an honest message is not sent");
    ++sent_;
    turn();
  }
  void fail(const char* what) {
    if (finding_.empty()) finding_ = what;
  }

  /// Output to the loop and to the front.
  void look() {
    if (world_.unit.proxies.take()) look(world_.unit.proxies.value());
    if (world_.unit.poses.take()) look(world_.unit.poses.value());
    if (world_.unit.settings.take()) look(world_.unit.settings.value());
    if (world_.unit.commands.take()) look(world_.unit.commands.value());
    Judged judged;
    int count = 0;
    while (out_.judged.read(judged_, judged)) {
      ++count;
      const Verdict& verdict = judged.verdict;
      if (verdict.verdict > IngressVerdict::kBadPlane) fail("an unknown verdict");
      if (verdict.used() != verdict.why.empty()) fail("a refusal without a word, or a word alone");
    }
    if (count > SampleIntake::kPerTurn) fail("more samples in a turn than are allowed");
    Answer answer;
    while (out_.answers.read(answers_, answer)) look(answer);
    Happened happened;
    while (out_.events.read(events_, happened)) {
      if (happened.event.reason.empty()) fail("an event without a reason");
      // Events of one moment are told a nanosecond apart.
      if (happened.event.time > now_ + 1ms) fail("an event from the future");
    }
  }
  void look(const Answer& answer) {
    if ((answer.id & kLocalIds) != 0) fail("an answer to the control socket");
    if (answer.refusal && answer.refusal->reason.empty()) fail("a refusal without a reason");
    if (!answer.refusal && !answer.session_id.empty()) ids_.push_back(answer.session_id);
    if (!answer.refusal && answer.lease.epoch != 0) epoch_ = answer.lease.epoch;
  }
  void look(const core::ProxySnapshot& proxy) {
    if (std::exchange(tenure_, proxy.tenure) != proxy.tenure) newest_seq_ = 0;
    if (proxy.mode == core::ProxyMode::kNone) return;  // a new lease
    if (proxy.seq <= newest_seq_) fail("the sequence went back");
    newest_seq_ = proxy.seq;
    const core::TimePoint now = steady_now();
    if (proxy.born > now || proxy.computed > now || proxy.gapless_since > now)
      fail("a proxy from the future");
    if (proxy.mode > core::ProxyMode::kPlanes) fail("an unknown mode");
    if (proxy.valid_for < 0s || proxy.valid_for > 2h) fail("a validity beyond the wire's");
    const auto n = proxy.x.size();
    if (n != kDofs && !(n == 0 && proxy.mode == core::ProxyMode::kFree)) fail("a wrong size");
    for (int i = 0; i < n; ++i) check(proxy.x[i], Ingress::kLargestCoordinate);
    if (!proxy.planes.fits(kDofs)) fail("contacts of a wrong size, or not finite");
    for (const double gamma : proxy.planes.compliance) {
      if (gamma < 0.0) fail("a compliance below 0");
      check(gamma, 1e18);
    }
    for (int p = 0; p < proxy.planes.laws.cols(); ++p) {
      for (int row = 0; row < 4; ++row) check(proxy.planes.laws(row, p), 1e18);
    }
    for (const double u : proxy.planes.uncertainty) {
      if (u < 0.0) fail("an uncertainty below 0");
      check(u, 1e6);
    }
    for (int p = 0; p < proxy.planes.offsets.size(); ++p) {
      check(proxy.planes.offsets[p], 1e9);
      for (int i = 0; i < kDofs; ++i) check(proxy.planes.normals(i, p), Ingress::kLargestNormal);
    }
  }
  void look(const core::TrackerSnapshot& pose) {
    if (pose.born > steady_now()) fail("a pose from the future");
    if (pose.valid_for <= 0s || pose.valid_for > 1h) fail("a pose's validity is off");
    for (const double value : pose.pose) check(value, 4.0);
  }
  void look(const core::RenderSettings& settings) {
    const core::RenderSettings& scene = world_.unit.config().scene;
    const auto within = [&](const core::VecA& value, const core::VecA& most) {
      return value.size() == most.size() && (value.array() >= 0.0).all() &&
             (value.array() <= most.array()).all();
    };
    if (!within(settings.stiffness, scene.stiffness) || !within(settings.damping, scene.damping) ||
        !within(settings.force_limit, scene.force_limit) ||
        !within(settings.slew_limit, scene.slew_limit)) {
      fail("settings beyond the scene's");
    }
    if (settings.renderer < core::RendererKind::kStandard ||
        settings.renderer > core::kRenderers.back()) {
      fail("an unknown renderer");
    }
    if (core::check(settings.staleness) != nullptr ||
        settings.staleness.fade_end > scene.staleness.fade_end) {
      fail("staleness limits beyond the scene's");
    }
  }
  void look(const core::CommandSnapshot& command) {
    const core::CommandSnapshot& before = command_;
    if (command.tenure < before.tenure || command.engage_id < before.engage_id ||
        command.release_id < before.release_id || command.stop_id < before.stop_id ||
        command.clear_id < before.clear_id || command.closing) {
      fail("a command went back");
    }
    command_ = command;
    began_ = true;
  }
  void check(double value, double limit) {
    if (!(std::abs(value) <= limit)) fail("a number that is not finite, or too large");
    if (std::fpclassify(value) == FP_SUBNORMAL) fail("a subnormal number");
  }

  World& world_{world()};
  SampleIntake intake_{*world_.owner, *world_.publisher};
  FrontRequests requests_{*world_.owner, *world_.publisher};
  const OwnersPages& out_{*static_cast<const OwnersPages*>(world_.read_pages.data())};
  Broadcast<Judged, 2048>::Cursor judged_{out_.judged.begin(0)};
  Broadcast<Answer, 512>::Cursor answers_{out_.answers.begin(0)};
  Broadcast<Happened, 512>::Cursor events_{out_.events.begin(0)};
  /// Arrivals are bounded by the clock: an hour of inputs fits in before it, or what the host has
  /// been up for.
  core::TimePoint now_{std::max(steady_now() - std::chrono::hours(1), core::TimePoint(1s))};
  core::TickRecord record_{};
  core::CommandSnapshot command_{};
  bool began_{false};  ///< a command was posted
  std::vector<SessionId> ids_{};
  std::uint64_t id_{100}, seq_{0}, newest_seq_{0};
  int sent_{0};  ///< messages that the owner has not received
  std::uint32_t epoch_{0}, tenure_{0};
  std::string finding_{};
};

}  // namespace
}  // namespace crossing

const FuzzTarget& crossing_target() {
  static const FuzzTarget kTarget{"crossing",
                                  [](FuzzInput input) { return crossing::Crossing().run(input); },
                                  crossing::seeds, 1024};
  return kTarget;
}

}  // namespace haptic::test
