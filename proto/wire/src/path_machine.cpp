#include "haptic/wire/path_machine.hpp"

#include <algorithm>
#include <utility>

namespace haptic::wire {
namespace {

constexpr Duration kLeastBetweenChallenges{std::chrono::milliseconds(10)};
constexpr int kChallengesPerSilence = 10;

template <typename Enum, std::size_t kSize>
const char* name_of(Enum value, const char* const (&names)[kSize]) noexcept {
  const auto number = static_cast<std::size_t>(value);
  return number < kSize ? names[number] : "UNKNOWN";
}

}  // namespace

const char* name(PathState state) noexcept {
  return name_of(state, {"OFF", "PROBING", "IN_USE", "WAITING"});
}

const char* name(PathChange change) noexcept {
  return name_of(change, {"NONE", "UDP_UP", "UDP_MOVED", "UDP_REFUSED", "UDP_SILENT", "UDP_LOSSY",
                          "UDP_CLOSED"});
}

PathMachine::PathMachine(const PathRules& rules, std::function<std::uint64_t()> token)
    : rules_(rules), token_(std::move(token)), backoff_(kFirstBackoff) {}

void PathMachine::start(const PeerAddress& to, TimePoint now) {
  stop();
  backoff_ = kFirstBackoff;
  address_ = to;
  state_ = PathState::kProbing;
  begin_round(to, now);
}

void PathMachine::stop() noexcept {
  state_ = PathState::kOff;
  round_.reset();
  unanswered_since_.reset();
  in_doubt_ = false;
  forget_round_challenges();
}

void PathMachine::heard(const PeerAddress& from, TimePoint now) {
  if (state_ == PathState::kOff) {
    if (now < restart_pause_) return;  // who leaves and comes back at once, again and again
    restart_pause_ = now + kFirstBackoff;
    return start(from, now);
  }
  if (from == address_ || now < candidate_pause_) return;
  if (state_ == PathState::kWaiting) {
    address_ = from;  // nothing goes there before a round of its own
    return;
  }
  if (round_ && round_->to == from) return;
  // One candidate at a time, and a pause after it: genuine datagrams from many addresses must not
  // make us send to many.
  if (state_ == PathState::kInUse && round_) return;
  candidate_pause_ = now + kFirstBackoff;
  address_ = state_ == PathState::kProbing ? from : address_;
  begin_round(from, now);
}

void PathMachine::begin_round(const PeerAddress& to, TimePoint now) {
  forget_round_challenges();
  round_ = Round{to, 0, 0, now, {}};
}

void PathMachine::forget_round_challenges() noexcept {
  for (Sent& sent : sent_) {
    if (sent.of_round) sent.answered = true;
  }
}

PathMachine::Sent* PathMachine::find(std::uint64_t token) noexcept {
  const auto sent = std::find_if(sent_.begin(), sent_.end(),
                                 [&](const Sent& s) { return !s.answered && s.token == token; });
  return sent == sent_.end() ? nullptr : &*sent;
}

std::optional<TimePoint> PathMachine::sent_at(std::uint64_t token) noexcept {
  const Sent* const sent = find(token);
  return sent != nullptr ? std::optional(sent->at) : std::nullopt;
}

PathChange PathMachine::responded(const PeerAddress& from, const PathResponse& response,
                                  TimePoint now) {
  Sent* const sent = find(response.token);
  // An answer from elsewhere proves nothing about where the challenge went.
  if (sent == nullptr || !(sent->to == from)) return PathChange::kNone;
  sent->answered = true;
  round_trip_.add(now - sent->at);
  if (sent->of_round) {
    return round_ && ++round_->answered >= kNeeded ? pass_round(now) : PathChange::kNone;
  }
  if (state_ != PathState::kInUse) return PathChange::kNone;
  loss_.add(response.packets, response.newest, now);
  // A challenge that was sent before this one and has no answer is lost or late; the silence runs
  // from the next one.
  std::optional<TimePoint> since;
  for (const Sent& other : sent_) {
    const bool open = !other.answered && !other.of_round && other.at > sent->at;
    if (open && (!since || other.at < *since)) since = other.at;
  }
  unanswered_since_ = since;
  judge_doubt(now);
  return PathChange::kNone;
}

PathChange PathMachine::pass_round(TimePoint now) {
  const bool was_in_use = in_use();
  address_ = round_->to;
  round_.reset();
  forget_round_challenges();
  state_ = PathState::kInUse;
  up_since_ = now;
  next_challenge_ = now;
  unanswered_since_.reset();
  in_doubt_ = false;
  loss_.restart();
  return was_in_use ? PathChange::kMoved : PathChange::kUp;
}

PathChange PathMachine::closed() noexcept {
  if (state_ == PathState::kOff) return PathChange::kNone;
  stop();
  return PathChange::kClosed;
}

void PathMachine::fall_back(TimePoint now) {
  if (in_use() && now - up_since_ >= kProvenAfter) backoff_ = kFirstBackoff;
  state_ = PathState::kWaiting;
  round_.reset();
  unanswered_since_.reset();
  forget_round_challenges();
  retry_at_ = now + backoff_;
  backoff_ = std::min(2 * backoff_, kLongestBackoff);
}

PathChange PathMachine::step(TimePoint now) {
  const PathChange change = judge(now);
  judge_doubt(now);
  return change;
}

void PathMachine::judge_doubt(TimePoint now) noexcept {
  in_doubt_ = in_use() && unanswered_since_ && now - *unanswered_since_ >= doubt_limit();
}

PathChange PathMachine::judge(TimePoint now) {
  if (state_ == PathState::kWaiting && now >= retry_at_) {
    state_ = PathState::kProbing;
    begin_round(address_, now);
  }
  if (round_ && round_->sent == kChallenges && now >= round_->ends) {
    if (!in_use()) {
      fall_back(now);
      return PathChange::kRefused;
    }
    round_.reset();  // the candidate's; the path in use is none the worse
    forget_round_challenges();
  }
  if (!in_use()) return PathChange::kNone;
  if (unanswered_since_ && now - *unanswered_since_ >= silence_limit()) {
    fall_back(now);
    return PathChange::kSilent;
  }
  const auto lost = loss_.share();
  if (lost && *lost > kLossy) {
    fall_back(now);
    return PathChange::kLossy;
  }
  return PathChange::kNone;
}

std::optional<DueChallenge> PathMachine::due(TimePoint now) {
  if (round_ && round_->sent < kChallenges && now >= round_->next) {
    ++round_->sent;
    round_->next = now + kSpacing;
    round_->ends = now + kPatience;
    return challenge(round_->to, kPaddedChallenge, true, now);
  }
  if (in_use() && now >= next_challenge_) {
    next_challenge_ =
        now + std::max(kLeastBetweenChallenges, silence_limit() / kChallengesPerSilence);
    if (!unanswered_since_) unanswered_since_ = now;
    return challenge(address_, kShortChallenge, false, now);
  }
  return std::nullopt;
}

DueChallenge PathMachine::challenge(const PeerAddress& to, std::size_t size, bool of_round,
                                    TimePoint now) {
  const std::uint64_t token = token_();
  sent_[next_slot_] = {token, to, now, of_round, false};
  next_slot_ = (next_slot_ + 1) % kRemembered;
  return {to, token, size};
}

Duration PathMachine::silence_limit() const noexcept {
  return std::max({kLeastSilence, 4 * rules_.nominal_period, 3 * round_trip_.smoothed()});
}

Duration PathMachine::doubt_limit() const noexcept {
  return round_trip_.smoothed() + 4 * round_trip_.variation() + rules_.overdue;
}

TimePoint PathMachine::next_step() const noexcept {
  if (state_ == PathState::kWaiting) return retry_at_;
  TimePoint next = TimePoint::max();
  if (round_) next = round_->sent < kChallenges ? round_->next : round_->ends;
  if (in_use()) {
    next = std::min(next, next_challenge_);
    if (unanswered_since_) next = std::min(next, *unanswered_since_ + silence_limit());
    if (unanswered_since_ && !in_doubt_) {
      next = std::min(next, *unanswered_since_ + doubt_limit());
    }
  }
  return next;
}

}  // namespace haptic::wire
