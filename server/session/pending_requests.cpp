#include "server/session/pending_requests.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "server/base/figures.hpp"

namespace haptic::server {
namespace {

Refusal not_yet(const char* reason, std::string message) {
  return {Refusal::Code::kPrecondition, reason, std::move(message), {}};
}

Outcome<Done> engage_outcome(const core::EngageAnswer& answer, core::DeviceState state) {
  using Verdict = core::EngageVerdict;
  const std::string value = figure(answer.value);
  const std::string limit = figure(answer.limit);
  switch (answer.verdict) {
    case Verdict::kAccepted:
      return Done{};
    case Verdict::kNone:
      break;
    case Verdict::kNotArmed:
      return not_yet("NOT_ARMED", "the device is " + std::string(core::name(state)) +
                                      ": force may be asked for in ARMED only");
    case Verdict::kStreamTooYoung:
      return not_yet("STREAM_TOO_YOUNG", "the stream runs without a gap for " + value +
                                             " ms: at least " + limit + " ms are needed");
    case Verdict::kTooFewSamples:
      return not_yet("TOO_FEW_SAMPLES", "the stream brought " + value +
                                            " samples without a gap: at least " + limit +
                                            " are needed");
    case Verdict::kStreamStale:
      if (!std::isfinite(answer.value)) {
        return not_yet("STREAM_STALE", "no proxy was accepted under this lease yet");
      }
      return not_yet("STREAM_STALE", "the newest proxy is " + value + " ms old: less than " +
                                         limit +
                                         " ms is needed (samples above twice the nominal rate do "
                                         "not count as fresh)");
    case Verdict::kDeviceStale:
      return not_yet("DEVICE_STALE", "the newest device sample is " + value + " ms old: at most " +
                                         limit + " ms is needed");
    case Verdict::kTrackerStale:
      if (!std::isfinite(answer.value)) {
        return not_yet("TRACKER_STALE", "no pose of a tracker was accepted yet");
      }
      return not_yet("TRACKER_STALE", "the tracker's newest pose is " + value +
                                          " ms old: less than " + limit + " ms is needed");
    case Verdict::kReleased:
      return not_yet("NOT_ARMED", "a Release came with it: ask again");
    case Verdict::kOutsideWindow:
      return not_yet("OUTSIDE_WINDOW", "force on actuated DoF " + std::to_string(answer.index) +
                                           " would start at " + value + " (N or N m): at most " +
                                           limit + " is allowed");
  }
  return Refusal{Refusal::Code::kUnavailable, "NO_ANSWER", "the loop gave no verdict", {}};
}

Outcome<core::FaultSet> clear_outcome(core::FaultSet asked, core::FaultSet refused) {
  const core::FaultSet persisting(asked.bits() & refused.bits());
  if (!persisting.any()) return asked;
  std::string names;
  for (unsigned n = 0; n < 32; ++n) {
    const auto fault = static_cast<core::Fault>(n);
    if (!persisting.has(fault)) continue;
    if (!names.empty()) names += ", ";
    names += std::string(core::reason(fault)) + " (" + std::to_string(n) + ")";
  }
  return not_yet("FAULT_PERSISTS", "the cause of " + names + " is still there");
}

}  // namespace

Ticket PendingRequests::add(Request request) {
  request.ticket = ++last_ticket_;
  requests_.push_back(std::move(request));
  return last_ticket_;
}

Ticket PendingRequests::add_engage(std::uint64_t id, std::string session_id, Answer answer) {
  Request request;
  request.kind = Kind::kEngage;
  request.id = id;
  request.session_id = std::move(session_id);
  request.answer = std::move(answer);
  return add(std::move(request));
}

Ticket PendingRequests::add_release(std::uint64_t id, std::string session_id, Answer answer) {
  Request request;
  request.kind = Kind::kRelease;
  request.id = id;
  request.session_id = std::move(session_id);
  request.answer = std::move(answer);
  return add(std::move(request));
}

Ticket PendingRequests::add_stop(std::uint64_t id, Answer answer) {
  Request request;
  request.kind = Kind::kStop;
  request.id = id;
  request.answer = std::move(answer);
  return add(std::move(request));
}

Ticket PendingRequests::add_clear(const AskedClear& asked, ClearAnswered answer) {
  Request request;
  request.kind = Kind::kClear;
  request.clear = asked;
  request.cleared = std::move(answer);
  return add(std::move(request));
}

bool PendingRequests::clear_waits() const noexcept {
  const auto first = std::find_if(requests_.begin(), requests_.end(),
                                  [](const Request& r) { return r.kind == Kind::kClear; });
  return first != requests_.end() && first->id == 0;
}

AskedClear PendingRequests::begin_clear(std::uint64_t id) noexcept {
  const auto first = std::find_if(requests_.begin(), requests_.end(),
                                  [](const Request& r) { return r.kind == Kind::kClear; });
  first->id = id;
  return first->clear;
}

bool PendingRequests::resolve(Request& request, const core::TickRecord& record,
                              Closures& closures) {
  const auto answer = [&](Outcome<Done> outcome) {
    closures.push_back(
        [call = std::move(request.answer), outcome = std::move(outcome)] { call(outcome); });
    return true;
  };
  switch (request.kind) {
    case Kind::kEngage:
      if (record.life.engage.id < request.id) return false;
      return answer(engage_outcome(record.life.engage, record.life.state));
    case Kind::kRelease:
      return record.life.release_id >= request.id && answer(Done{});
    case Kind::kStop:
      return record.life.stop_id >= request.id && answer(Done{});
    case Kind::kClear:
      if (request.id == 0 || record.life.clear.id < request.id) return false;
      closures.push_back([call = std::move(request.cleared),
                          outcome = clear_outcome(request.clear.faults,
                                                  record.life.clear.refused)] { call(outcome); });
      return true;
  }
  return false;
}

void PendingRequests::step(const core::TickRecord& record, Closures& closures) {
  for (auto it = requests_.begin(); it != requests_.end();) {
    bool done = resolve(*it, record, closures);
    if (!done && --it->patience <= 0) {
      const Refusal refusal{
          Refusal::Code::kUnavailable,
          "NO_ANSWER",
          "the loop gave no answer within " + std::to_string(kPatience) + " ticks",
          {}};
      if (it->answer) {
        closures.push_back([call = std::move(it->answer), refusal] { call(refusal); });
      } else {
        closures.push_back([call = std::move(it->cleared), refusal] { call(refusal); });
      }
      done = true;
    }
    it = done ? requests_.erase(it) : std::next(it);
  }
}

bool PendingRequests::lease_ended(const std::string& session_id, Closures& closures) {
  bool engage = false;
  for (auto it = requests_.begin(); it != requests_.end();) {
    const bool of_lease =
        (it->kind == Kind::kEngage || it->kind == Kind::kRelease) && it->session_id == session_id;
    if (!of_lease) {
      ++it;
      continue;
    }
    // The end of a lease releases by itself, so a release that still waits has what it wanted.
    const Outcome<Done> outcome =
        it->kind == Kind::kRelease
            ? Outcome<Done>(Done{})
            : Outcome<Done>(Refusal{Refusal::Code::kPermission,
                                    "NOT_CONTROLLER",
                                    "the lease ended before the loop answered",
                                    {}});
    closures.push_back([call = std::move(it->answer), outcome] { call(outcome); });
    engage = engage || it->kind == Kind::kEngage;
    it = requests_.erase(it);
  }
  return engage;
}

PendingRequests::Cancelled PendingRequests::cancel(Ticket ticket) {
  const auto found = std::find_if(requests_.begin(), requests_.end(),
                                  [&](const Request& r) { return r.ticket == ticket; });
  if (found == requests_.end()) return Cancelled::kNothing;
  const bool engage = found->kind == Kind::kEngage;
  requests_.erase(found);
  return engage ? Cancelled::kEngage : Cancelled::kRequest;
}

}  // namespace haptic::server
