#include "server/owner/link/front_link.hpp"

#include <sched.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/wait.h>

#include <algorithm>
#include <utility>

#include "haptic/core/error.hpp"
#include "haptic/wire/control_names.hpp"
#include "server/base/steady_now.hpp"
#include "server/base/thread_setup.hpp"
#include "server/crossing/link_messages.hpp"

namespace haptic::server {
namespace {

using namespace std::chrono_literals;

constexpr core::Duration kFirstPause = 100ms;
constexpr core::Duration kLongestPause = 2s;
/// A front that lived this long did not fail by what it does at its start.
constexpr core::Duration kLasted = 1s;
/// At least so often the fronts' signs of life are looked at.
constexpr int kLookEveryMs = 50;

std::string how_it_ended(int status) {
  if (WIFSIGNALED(status)) return std::string("was ended by SIG") + sigabbrev_np(WTERMSIG(status));
  return "ended with status " + std::to_string(WEXITSTATUS(status));
}

}  // namespace

FrontLink::FrontLink(Owner& owner, Config config)
    : owner_(owner),
      config_(std::move(config)),
      front_config_(config_.hand_over ? to_memory(config_.hand_over->config()) : SharedMemory()),
      publisher_(std::make_shared<Publisher>(
          owner, [this](const Answer& answer) { local_.on_answer(answer); })),
      local_(owner, [this](std::uint64_t reply_to) { restart_asked(reply_to); }),
      wakes_(event_descriptor()),
      intake_(owner, *publisher_),
      requests_(owner, *publisher_) {
  owner_.connect(publisher_);
}

FrontLink::~FrontLink() {
  stop();
}

void FrontLink::start() {
  publish_facts();
  listen_locally();
  thread_ = std::thread([this] { run(); });
  if (config_.launcher != nullptr) first_.get_future().get();
}

void FrontLink::listen_locally() {
  LocalCommands::Config local{{control_folder(), {}}, addresses(), config_.realtime};
  std::vector<std::string>& names = local.places.names;
  if (!config_.hand_over) names.push_back(config_.name);
  for (const std::string& address : addresses()) {
    for (const std::string& name : wire::control_names(address)) names.push_back(name);
  }
  local_.listen(std::move(local));
}

void FrontLink::stop() {
  stopping_.store(true);
  static_cast<void>(eventfd_write(wakes_.get(), 1));
  if (thread_.joinable()) thread_.join();
  local_.stop();
}

void FrontLink::restart() {
  restart_wanted_.store(true);
  static_cast<void>(eventfd_write(wakes_.get(), 1));
}

std::vector<std::string> FrontLink::addresses() const {
  return config_.hand_over ? config_.hand_over->addresses() : std::vector<std::string>{};
}

void FrontLink::run() noexcept {
  set_thread_up("front link");
  const sched_param lowest{1};
  if (config_.realtime) sched_setscheduler(0, SCHED_FIFO, &lowest);
  bool told_to_leave = false;
  for (;;) {
    turn();
    keep_within_budget();
    if (!stopping_.load()) continue;
    if (!std::exchange(told_to_leave, true)) {
      if (next_) end(*next_, "hapticd stops");
      if (current_ && current_->stage <= Stage::kServing) leave(*current_);
    }
    if (!current_ && !next_) return;
  }
}

void FrontLink::wait_for_news() {
  wait_.assign(1, {wakes_.get(), POLLIN, 0});
  if (config_.launcher != nullptr && !told_lost_) {
    wait_.push_back({config_.launcher->descriptor(), POLLIN, 0});
  }
  for (const Place* place : {&current_, &next_}) {
    if (!*place) continue;
    if ((*place)->link) wait_.push_back({(*place)->link.get(), POLLIN, 0});
    wait_.push_back({(*place)->wakes_owner.get(), POLLIN, 0});
  }
  poll(wait_.data(), wait_.size(), kLookEveryMs);
}

void FrontLink::turn() {
  wait_for_news();
  now_ = steady_now();
  if (intake_.take()) static_cast<void>(eventfd_write(wakes_.get(), 1));
  for (const Place* place : {&current_, &next_}) {
    if (!*place) continue;
    FrontProcess& front = **place;
    front.hear();
    if (!take_messages(front)) end(front, wrong_);
    requests_.take_stops(front, now_);
  }
  empty(wakes_);
  if (const std::uint64_t reply_to = restart_asked_.exchange(0)) restart_for(reply_to);
  if (config_.launcher != nullptr) {
    notices();
    look_after();
  }
  publish_facts();
}

/// Any thread.
void FrontLink::restart_asked(std::uint64_t reply_to) {
  local_.answer(restart_asked_.exchange(reply_to), "refused: another restart was asked for");
  static_cast<void>(eventfd_write(wakes_.get(), 1));
}

void FrontLink::restart_for(std::uint64_t reply_to) {
  if (config_.launcher == nullptr) {
    return local_.answer(reply_to, "refused: the scene is offline: it has no front");
  }
  if (next_ || stopping_.load()) {
    return local_.answer(reply_to, "refused: a front is being started or ended");
  }
  restart_reply_ = reply_to;
  start_front();
}

void FrontLink::start_front() {
  try {
    next_ = std::make_unique<FrontProcess>(++generation_, now_);
    config_.launcher->start(std::move(next_->its_link));
  } catch (const std::exception& error) {
    wrong_ = error.what();
    if (next_) next_->gone = true;
  }
}

void FrontLink::notices() {
  while (const auto notice = config_.launcher->next()) {
    if (notice->kind == Launcher::Notice::Kind::kStarted) {
      if (!next_ || next_->pid != 0) continue;
      next_->pid = notice->pid;
      facts_due_ = now_;
      if (next_->stage == Stage::kKilled) config_.launcher->kill(notice->pid);
      continue;
    }
    for (const Place* place : {&current_, &next_}) {
      if (!*place || (*place)->pid != notice->pid) continue;
      FrontProcess& front = **place;
      if (front.stage < Stage::kLeaving) {
        wrong_ = "hapticd-front " + how_it_ended(notice->status);
        if (first_told_) spdlog::error("{} (process {})", wrong_, notice->pid);
      }
      front.gone = true;
    }
  }
  if (!config_.launcher->gone() || std::exchange(told_lost_, true)) return;
  wrong_ = "hapticd-front cannot be started: its launcher is gone";
  for (const Place* place : {&current_, &next_}) {
    if (*place) (*place)->gone = true;  // fronts end with their launcher
  }
  if (!stopping_.load() && config_.lost) config_.lost();
}

void FrontLink::look_after() {
  for (Place* place : {&current_, &next_}) {
    if (!*place) continue;
    FrontProcess& front = **place;
    if (front.gone) {
      clear_away(*place);
      continue;
    }
    front.look(now_);
    const core::Duration in_stage = now_ - front.since;
    const bool starts = front.stage == Stage::kStarting || front.stage == Stage::kPreparing ||
                        front.stage == Stage::kOpening;
    if (starts && in_stage > kStarting) end(front, "hapticd-front did not serve within 10 s");
    if (front.stage == Stage::kServing && now_ - front.beat_at > kSilence) {
      end(front, "hapticd-front gave no sign of life for 2 s");
    }
    if (front.stage == Stage::kLeaving && in_stage > kLeaving)
      end(front, "hapticd-front does not leave");
  }
  tell_to_go();
  if (stopping_.load() || told_lost_) return;
  if (restart_wanted_.exchange(false) && !next_ && current_) start_front();
  if (!current_ && !next_ && now_ >= start_at_) start_front();
}

bool FrontLink::welcome(FrontProcess& front) {
  try {
    const FrontStart start = config_.hand_over->start();
    wrong_ = "hapticd-front does not listen";
    return front.welcome(publisher_->descriptor(), front_config_, start);
  } catch (const std::exception& error) {
    wrong_ = error.what();
    return false;
  }
}

void FrontLink::tell_to_go() {
  if (!next_ || next_->stage != Stage::kReady) return;
  if (current_) {
    if (current_->stage <= Stage::kServing) leave(*current_);
    return;
  }
  current_ = std::move(next_);
  current_->enter(Stage::kOpening, now_);
  send(current_->link.get(), OwnerMessage{OwnerMessage::Kind::kGo});
}

void FrontLink::leave(FrontProcess& front) {
  send(front.link.get(), OwnerMessage{OwnerMessage::Kind::kLeave});
  front.enter(Stage::kLeaving, now_);
  choose_samples();
}

void FrontLink::end(FrontProcess& front, const std::string& why) {
  wrong_ = why;
  if (!stopping_.load() && first_told_) {
    spdlog::error("{}: it is ended (process {})", why, front.pid);
  }
  if (front.pid > 0) config_.launcher->kill(front.pid);
  front.enter(Stage::kKilled, now_);
  choose_samples();
  front.link = Descriptor();
}

void FrontLink::clear_away(Place& place) {
  const bool was_current = &place == &current_;
  const bool lasted =
      place->served_since != core::TimePoint{} && now_ - place->served_since > kLasted;
  const bool told = place->stage == Stage::kLeaving;
  if (place->link) {
    // Takes what it sent before it ended, stops above all.
    static_cast<void>(take_messages(*place));
  }
  for (std::size_t i = 0; i < kFrontCounters; ++i) {
    counted_[i] += place->pages.counters[i].load(std::memory_order_relaxed);
  }
  publisher_->counted(counted_);
  choose_samples();
  place.reset();
  facts_due_ = now_;
  if (was_current) {
    owner_.front_gone();
    publisher_->forget_answers();
  }
  if (!told) {
    pause_ = lasted ? core::Duration{0}
                    : std::clamp<core::Duration>(2 * pause_, kFirstPause, kLongestPause);
    start_at_ = now_ + pause_;
    local_.answer(std::exchange(restart_reply_, 0), "refused: " + wrong_);
  }
  if (stopping_.load() || std::exchange(first_told_, true)) return;
  first_.set_exception(std::make_exception_ptr(core::TransportError(wrong_)));
}

}  // namespace haptic::server
