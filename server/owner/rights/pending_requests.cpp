#include "server/owner/rights/pending_requests.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "server/base/figures.hpp"

namespace haptic::server {
namespace {

Refusal not_yet(const char* reason, const std::string& message) {
  return {Refusal::Code::kPrecondition, reason, message};
}

}  // namespace

std::string too_fast(const core::StreamRate& rate) {
  return figure(rate.comes_hz) + " samples/s come, " + figure(rate.announced_hz) +
         " were announced: at most twice as many count as fresh";
}

std::optional<Refusal> engage_refusal(const core::EngageAnswer& answer,
                                      core::LifecycleState state) {
  using core::EngageVerdict;
  const std::string value = figure(answer.value);
  const std::string limit = figure(answer.limit);
  switch (answer.verdict) {
    case EngageVerdict::kAccepted:
      return std::nullopt;
    case EngageVerdict::kNone:
      break;
    case EngageVerdict::kNotArmed:
      return not_yet("NOT_ARMED", "the device is " + std::string(core::name(state)) +
                                      ": force may be asked for in ARMED only" +
                                      (state == core::LifecycleState::kFault
                                           ? "; clear the fault (hapticctl clear-fault)"
                                           : ""));
    case EngageVerdict::kStreamTooYoung:
      return not_yet("STREAM_TOO_YOUNG", "the stream runs without a gap for " + value +
                                             " ms: at least " + limit + " ms are needed");
    case EngageVerdict::kTooFewSamples:
      return not_yet("TOO_FEW_SAMPLES", "the stream brought " + value +
                                            " samples without a gap: at least " + limit +
                                            " are needed");
    case EngageVerdict::kStreamStale:
      if (!std::isfinite(answer.value)) {
        return not_yet("STREAM_STALE", "no proxy was accepted under this lease yet");
      }
      return not_yet("STREAM_STALE", "the newest proxy is " + value + " ms old: less than " +
                                         limit + " ms is needed");
    case EngageVerdict::kTooFast:
      return not_yet("TOO_FAST", too_fast({answer.value, answer.limit}));
    case EngageVerdict::kDeviceStale:
      return not_yet("DEVICE_STALE", "the newest device sample is " + value + " ms old: at most " +
                                         limit + " ms is needed");
    case EngageVerdict::kTrackerStale:
      if (!std::isfinite(answer.value)) {
        return not_yet("TRACKER_STALE", "no pose of a tracker was accepted yet");
      }
      return not_yet("TRACKER_STALE", "the tracker's newest pose is " + value +
                                          " ms old: less than " + limit + " ms is needed");
    case EngageVerdict::kReleased:
      return not_yet("NOT_ARMED", "a Release came with it: ask again");
    case EngageVerdict::kNeverFree:
      return not_yet(
          "NEVER_FREE",
          "the proxy was held under this lease all the time, which does not say on "
          "which side of an object the probe is: publish it free for a few samples, or planes");
    case EngageVerdict::kOutsideWindow:
      return not_yet("OUTSIDE_WINDOW", "force on actuated DoF " + std::to_string(answer.index) +
                                           " would start at " + value + " (N or N m): at most " +
                                           limit + " is allowed");
  }
  return Refusal{Refusal::Code::kUnavailable, "NO_ANSWER", "the loop gave no verdict"};
}

namespace {

/// Answers a clear: the faults that it asked for, or which of them persist.
void answer_clear(core::FaultSet asked, core::FaultSet refused, Answer& answer) {
  const core::FaultSet persisting(asked.bits() & refused.bits());
  if (!persisting.any()) {
    answer.faults = asked;
    return;
  }
  std::string names;
  for (unsigned n = 0; n < 32; ++n) {
    const auto fault = static_cast<core::Fault>(n);
    if (!persisting.has(fault)) continue;
    if (!names.empty()) names += ", ";
    names += std::string(core::reason(fault)) + " (" + std::to_string(n) + ")";
  }
  answer.refusal = not_yet("FAULT_PERSISTS", "the cause of " + names + " is still there");
}

}  // namespace

void PendingRequests::add(const Request& request, std::uint64_t posted) {
  requests_.push_back({request.id, request.kind, posted, request.session_id, {}});
}

void PendingRequests::add_clear(const Request& request, const AskedClear& asked) {
  requests_.push_back({request.id, request.kind, 0, request.session_id, asked});
}

std::optional<AskedClear> PendingRequests::begin_clear(std::uint64_t posted) noexcept {
  const auto first = std::find_if(requests_.begin(), requests_.end(), [](const Pending& pending) {
    return pending.kind == Request::Kind::kClear;
  });
  if (first == requests_.end() || first->posted != 0) return std::nullopt;
  first->posted = posted;
  return first->clear;
}

bool PendingRequests::resolve(const Pending& pending, const core::TickRecord& record,
                              Answers& answers) {
  const bool engage = pending.kind == Request::Kind::kEngage;
  const bool clear = pending.kind == Request::Kind::kClear;
  const std::uint64_t answered = engage                                    ? record.life.engage.id
                                 : clear                                   ? record.life.clear.id
                                 : pending.kind == Request::Kind::kRelease ? record.life.release_id
                                                                           : record.life.stop_id;
  if (pending.posted == 0 || answered < pending.posted) return false;
  answers.emplace_back(Answer{pending.id});
  if (engage) answers.back().refusal = engage_refusal(record.life.engage, record.life.state);
  if (engage && !answers.back().refusal) accepted_engage_ = pending.id;
  if (clear) answer_clear(pending.clear.faults, record.life.clear.refused, answers.back());
  return true;
}

bool PendingRequests::step(const core::TickRecord& record, Answers& answers) {
  bool gave_up_engage = false;
  std::erase_if(requests_, [&](Pending& pending) {
    if (resolve(pending, record, answers)) return true;
    if (--pending.patience > 0) return false;
    answers.emplace_back(Answer{pending.id}).refusal = {
        Refusal::Code::kUnavailable, "NO_ANSWER",
        "the loop gave no answer within " + std::to_string(kPatience) + " ticks"};
    gave_up_engage = gave_up_engage || pending.kind == Request::Kind::kEngage;
    return true;
  });
  return gave_up_engage;
}

bool PendingRequests::lease_ended(const SessionId& session_id, Answers& answers) {
  bool engage = false;
  std::erase_if(requests_, [&](const Pending& pending) {
    const bool is_engage = pending.kind == Request::Kind::kEngage;
    const bool of_lease = is_engage || pending.kind == Request::Kind::kRelease;
    if (!of_lease || !(pending.session_id == session_id)) return false;
    // The end of a lease releases by itself, so a release that still waits has what it wanted.
    Answer& answer = answers.emplace_back(Answer{pending.id});
    if (is_engage) {
      answer.refusal = {Refusal::Code::kPermission, "NOT_CONTROLLER",
                        "the lease ended before the loop answered"};
    }
    engage = engage || is_engage;
    return true;
  });
  return engage;
}

void PendingRequests::refuse_all(const Refusal& why, Answers& answers) {
  for (const Pending& pending : requests_) answers.emplace_back(Answer{pending.id, why});
  requests_.clear();
}

bool PendingRequests::cancel(std::uint64_t id) {
  const auto found = std::find_if(requests_.begin(), requests_.end(),
                                  [&](const Pending& pending) { return pending.id == id; });
  if (found == requests_.end()) {
    const bool accepted = id != 0 && id == accepted_engage_;
    if (accepted) forget_engage();
    return accepted;
  }
  const bool engage = found->kind == Request::Kind::kEngage;
  requests_.erase(found);
  return engage;
}

}  // namespace haptic::server
