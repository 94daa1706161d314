// FrontLink: what fronts send, what they are told of the server, and whether both go on.
#include <spdlog/spdlog.h>

#include <utility>

#include "server/base/process.hpp"
#include "server/base/steady_now.hpp"
#include "server/crossing/link_messages.hpp"
#include "server/owner/link/front_link.hpp"

namespace haptic::server {
namespace {

using namespace std::chrono_literals;

/// Messages of one kind in one turn: the other front, the control socket and the clock come
/// between.
constexpr int kMessagesPerTurn = 64;

}  // namespace

bool FrontLink::hear(FrontProcess& front) {
  const bool words = front.log.copy(now_);
  if (front.stage == Stage::kKilled) return true;
  if (!words) {
    wrong_ = "hapticd-front sent descriptors as words";
    return false;
  }
  if (front.is_heard() && !intake_.take(front)) {
    wrong_ = "hapticd-front sent a sample that is none";
    return false;
  }
  requests_.take_stops(front, now_);
  return take_messages(front);
}

bool FrontLink::take_messages(FrontProcess& front) {
  for (int i = 0; i < kMessagesPerTurn && front.link; ++i) {
    FrontMessage message;
    switch (receive(front.link.get(), message)) {
      case Received::kNothing:
        return true;
      case Received::kGone:
        close_aside(std::move(front.link));  // its end is told by the launcher
        return true;
      case Received::kOdd:
        wrong_ = "hapticd-front is of another build: its messages have another size";
        return false;
      case Received::kBurdened:
        wrong_ = "hapticd-front sent descriptors";
        return false;
      case Received::kMessage:
        if (!take(front, message)) return false;
    }
  }
  return true;
}

bool FrontLink::take(FrontProcess& front, FrontMessage& message) {
  switch (message.kind) {
    case FrontMessage::Kind::kHello:
      if (front.stage != Stage::kStarting) return true;
      if (message.layout != layout_hash()) {
        wrong_ = "hapticd-front is of another build: its layout is not this hapticd's";
        return false;
      }
      front.enter(Stage::kPreparing, now_);
      return welcome(front);
    case FrontMessage::Kind::kReady:
      if (front.stage == Stage::kPreparing) front.enter(Stage::kReady, now_);
      return true;
    case FrontMessage::Kind::kServing:
      if (front.stage == Stage::kOpening) serves_now(front);
      return true;
    case FrontMessage::Kind::kCannotServe:
      if (front.stage >= Stage::kServing) return true;
      wrong_ = message.text.str();
      return false;
    case FrontMessage::Kind::kRequest:
      if (front.is_heard()) requests_.post(front, message.request, now_);
      return true;
    case FrontMessage::Kind::kBeat:
      front.beat_at = now_;
      front.counters = message.counters;
      return true;
  }
  return true;
}

void FrontLink::serves_now(FrontProcess& front) {
  front.enter(Stage::kServing, now_);
  front.served_since = now_;
  ++served_;
  facts_due_ = now_;
  if (!std::exchange(first_told_, true)) first_.set_value();
  if (served_ > 1) spdlog::info("front number {} serves (process {})", served_, front.pid);
  local_.answer(std::exchange(restart_reply_, 0), "ok\na new front serves");
}

void FrontLink::watch_launcher() {
  const bool silent = config_.launcher->is_silent(now_);
  if (silent == std::exchange(launcher_silent_, silent)) return;
  if (silent) {
    spdlog::error("the launcher of the front does not answer (process {}): no front can be started",
                  config_.launcher->pid());
  } else {
    spdlog::warn("the launcher of the front answers again");
  }
}

/// The link's thread waits in the kernel for something that a front does, which no call of it
/// should. Another thread calls.
void FrontLink::free_thread() {
  if (config_.launcher == nullptr) return;
  spdlog::error("the thread that hears the front does not turn: the front is ended");
  for (const auto& pid : alive_) config_.launcher->kill(pid.load());
}

void FrontLink::publish_facts() {
  if (now_ < facts_due_) return;
  facts_due_ = now_ + 100ms;
  ServerFacts facts = config_.facts();
  facts.resident_bytes = resident_bytes();
  facts.fronts_served = served_;
  publisher_->facts(facts);
  const bool serves = current_ && current_->stage == Stage::kServing;
  local_.front({serves, current_ ? current_->pid : 0, served_,
                serves ? current_->served_since : core::TimePoint{}, serves ? "" : wrong_});
  if (!config_.ticks) return;
  for (std::size_t i = 0; i < owner_.devices().size(); ++i) {
    publisher_->totals(i, config_.ticks->totals(i));
  }
}

}  // namespace haptic::server
