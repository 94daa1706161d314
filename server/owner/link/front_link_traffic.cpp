// FrontLink: what fronts send, and what they are told of the server.
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>

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

/// Whatever fronts send, this thread leaves two thirds of a core to others.
void FrontLink::keep_within_budget() {
  constexpr core::Duration kWindow = 3ms, kBudget = 1ms;
  const core::TimePoint now = steady_now();
  busy_ += now - now_;
  if (now - window_ < kWindow) {
    if (busy_ < kBudget) return;
    std::this_thread::sleep_for(window_ + kWindow - now);
  }
  window_ = steady_now();
  busy_ = {};
}

bool FrontLink::take_messages(FrontProcess& front) {
  // Stops that rose before the queue was seen empty were in it.
  std::array<std::uint32_t, kMostDevices> stops{};
  for (std::size_t i = 0; i < stops.size(); ++i) {
    stops[i] = front.pages.stops[i].load(std::memory_order_acquire);
  }
  front.queued = false;
  for (int i = 0; i < kMessagesPerTurn && front.link; ++i) {
    FrontMessage message;
    switch (receive(front.link.get(), message)) {
      case Received::kNothing:
        front.stops.assign(stops.begin(), stops.end());
        return true;
      case Received::kGone:
        front.link = Descriptor();  // its end is told by the launcher
        return true;
      case Received::kOdd:
        wrong_ = "hapticd-front is of another build: its messages have another size";
        return false;
      case Received::kMessage:
        if (!take(front, message)) return false;
    }
  }
  front.queued = true;
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
      if (front.stage != Stage::kServing && front.stage != Stage::kLeaving) return true;
      requests_.post(front, message.request, now_);
      return true;
  }
  return true;
}

void FrontLink::serves_now(FrontProcess& front) {
  front.enter(Stage::kServing, now_);
  choose_samples();
  front.served_since = now_;
  ++served_;
  facts_due_ = now_;
  if (!std::exchange(first_told_, true)) first_.set_value();
  if (served_ > 1) spdlog::info("front number {} serves (process {})", served_, front.pid);
  local_.answer(std::exchange(restart_reply_, 0), "ok\na new front serves");
}

/// From now on the samples of the front that serves, if one does, are taken.
void FrontLink::choose_samples() {
  const bool serves = current_ && !current_->gone && current_->stage == Stage::kServing;
  intake_.serve(serves ? &current_->pages : nullptr);
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
  local_.bar({config_.launcher != nullptr ? config_.launcher->pid() : 0,
              current_ ? current_->pid : 0, next_ ? next_->pid : 0});
  if (!config_.ticks) return;
  for (std::size_t i = 0; i < owner_.devices().size(); ++i) {
    publisher_->totals(i, config_.ticks->totals(i));
  }
}

}  // namespace haptic::server
