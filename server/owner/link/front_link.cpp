#include "server/owner/link/front_link.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "haptic/core/error.hpp"
#include "haptic/wire/control_names.hpp"
#include "server/base/steady_now.hpp"
#include "server/base/thread_setup.hpp"

namespace haptic::server {
namespace {

using namespace std::chrono_literals;

constexpr core::Duration kFirstPause = 100ms;
constexpr core::Duration kLongestPause = 2s;
/// A front that lived this long did not fail by what it does at its start.
constexpr core::Duration kLasted = 1s;
/// At least so often the fronts' signs of life are looked at.
constexpr int kLookEveryMs = 50;
/// A front that was killed ends within this, or its launcher does not work.
constexpr core::Duration kEnding = 500ms;
/// No front is started while so many sockets of former ones are not closed yet.
constexpr int kMostClosing = 8;

}  // namespace

FrontLink::FrontLink(Owner& owner, Config config)
    : owner_(owner),
      config_(std::move(config)),
      front_config_(config_.hand_over ? to_memory(config_.hand_over->config()) : SharedMemory()),
      publisher_(std::make_shared<Publisher>(
          owner, [this](const Answer& answer) { local_.on_answer(answer); })),
      local_(owner, [this](std::uint64_t reply_to) { restart_asked(reply_to); }),
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
  if (config_.launcher != nullptr) local.launcher = config_.launcher->pid();
  std::vector<std::string>& names = local.places.names;
  if (!config_.hand_over) names.push_back(config_.name);
  for (const std::string& address : addresses()) {
    for (const std::string& name : wire::control_names(address)) names.push_back(name);
  }
  local_.listen(std::move(local));
}

void FrontLink::stop() {
  stopping_.store(true);
  wakes_.wake();
  if (thread_.joinable()) thread_.join();
  watch_.end();
  local_.stop();
}

void FrontLink::restart() {
  restart_wanted_.store(true);
  wakes_.wake();
}

std::vector<std::string> FrontLink::addresses() const {
  return config_.hand_over ? config_.hand_over->addresses() : std::vector<std::string>{};
}

void FrontLink::run() noexcept {
  set_thread_up("front link", config_.realtime);
  bool told_to_leave = false;
  for (;;) {
    turn();
    watch_.turned();
    share_.rest(now_);
    if (!stopping_.load()) continue;
    if (!std::exchange(told_to_leave, true)) {
      if (next_) end(*next_, "hapticd stops");
      if (current_ && current_->stage <= Stage::kServing) leave(*current_);
    }
    if (!current_ && !next_) return;
  }
}

void FrontLink::wait_for_news() {
  wait_.assign(1, {wakes_.descriptor(), POLLIN, 0});
  if (config_.launcher != nullptr && !told_lost_) {
    wait_.push_back({config_.launcher->descriptor(), POLLIN, 0});
  }
  for (const Place* place : {&current_, &next_}) {
    if (!*place) continue;
    wait_.push_back({(*place)->log.descriptor(), POLLIN, 0});  // poll() passes over -1
    if ((*place)->stage == Stage::kKilled) continue;
    wait_.push_back({(*place)->link.get(), POLLIN, 0});
    if ((*place)->is_heard()) wait_.push_back({(*place)->samples.get(), POLLIN, 0});
  }
  poll(wait_.data(), wait_.size(), kLookEveryMs);
}

void FrontLink::turn() {
  wait_for_news();
  now_ = steady_now();
  for (const Place* place : {&current_, &next_}) {
    if (*place && !hear(**place)) end(**place, wrong_);
  }
  wakes_.forget();
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
  wakes_.wake();
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

template <typename Act>
bool FrontLink::try_to(const Act& act) {
  try {
    return act();
  } catch (const std::exception& error) {
    wrong_ = error.what();
    return false;
  }
}

void FrontLink::start_front() {
  const bool started = try_to([this] {
    next_ = std::make_unique<FrontProcess>(++generation_, now_);
    config_.launcher->start(std::move(next_->its_link), std::move(next_->its_log));
    return true;
  });
  if (!started && next_) next_->gone = true;
}

void FrontLink::notices() {
  while (const auto notice = config_.launcher->next()) {
    if (notice->kind == Launcher::Notice::Kind::kHere) continue;
    if (notice->kind == Launcher::Notice::Kind::kStarted) {
      // The newest one; a launcher that was late has it serve already.
      FrontProcess* const front = next_ ? next_.get() : current_.get();
      if (front == nullptr || front->pid != 0) continue;
      front->pid = notice->pid;
      alive_[generation_ % 2].store(notice->pid);
      facts_due_ = now_;
      if (front->stage == Stage::kKilled) config_.launcher->kill(notice->pid);
      continue;
    }
    for (const Place* place : {&current_, &next_}) {
      if (!*place || (*place)->pid != notice->pid) continue;
      FrontProcess& front = **place;
      if (front.stage < Stage::kLeaving) {
        wrong_ = "hapticd-front " + notice->words();
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
    const core::Duration in_stage = now_ - front.since;
    const bool starts = front.stage == Stage::kStarting || front.stage == Stage::kPreparing ||
                        front.stage == Stage::kOpening;
    if (starts && in_stage > kStarting) end(front, "hapticd-front did not serve within 10 s");
    if (front.stage == Stage::kServing && now_ - front.beat_at > kSilence) {
      end(front, "hapticd-front gave no sign of life for 2 s");
    }
    if (front.stage == Stage::kLeaving && in_stage > kLeaving)
      end(front, "hapticd-front does not leave");
    if (front.stage == Stage::kKilled && stopping_.load() && in_stage > kEnding) {
      config_.launcher->end();  // it does not obey either
    }
  }
  watch_launcher();
  tell_to_go();
  if (stopping_.load() || told_lost_) return;
  if (restart_wanted_.exchange(false) && !next_ && current_) start_front();
  if (!current_ && !next_ && now_ >= start_at_ && closing_aside() < kMostClosing) start_front();
}

bool FrontLink::welcome(FrontProcess& front) {
  return try_to([&] {
    const std::vector<Descriptor> files = config_.hand_over->files();
    wrong_ = "hapticd-front does not listen";
    return front.welcome(publisher_->memory(), front_config_, files);
  });
}

bool FrontLink::go(FrontProcess& front) {
  return try_to([&] {
    Listeners& listeners = config_.hand_over->listeners();
    listeners.check();
    wrong_ = "hapticd-front does not listen";
    return front.go(listeners.sockets());
  });
}

void FrontLink::tell_to_go() {
  if (!next_ || next_->stage != Stage::kReady) return;
  if (current_) {
    if (current_->stage <= Stage::kServing) leave(*current_);
    return;
  }
  current_ = std::move(next_);
  current_->enter(Stage::kOpening, now_);
  if (!go(*current_)) end(*current_, wrong_);
}

void FrontLink::leave(FrontProcess& front) {
  send(front.link.get(), OwnerMessage{OwnerMessage::Kind::kLeave});
  front.enter(Stage::kLeaving, now_);
}

void FrontLink::end(FrontProcess& front, const std::string& why) {
  wrong_ = why;
  if (!stopping_.load() && first_told_) {
    spdlog::error("{}: it is ended (process {})", why, front.pid);
  }
  if (front.pid > 0) config_.launcher->kill(front.pid);
  front.enter(Stage::kKilled, now_);
}

void FrontLink::clear_away(Place& place) {
  const bool was_current = &place == &current_;
  const bool lasted =
      place->served_since != core::TimePoint{} && now_ - place->served_since > kLasted;
  const bool told = place->stage == Stage::kLeaving;
  for (int i = 0; i < 32 && hear(*place); ++i) continue;  // what it sent before, stops above all
  for (std::size_t i = 0; i < kFrontCounters; ++i) counted_[i] += place->counters[i];
  publisher_->counted(counted_);
  alive_[place->generation % 2].store(0);
  place.reset();
  facts_due_ = now_;
  if (was_current) {
    owner_.front_gone();
    publisher_->forget_answers();
  }
  Listeners& listeners = config_.hand_over->listeners();
  if (was_current && (!told || (listeners.may_be_copied() && !stopping_.load()))) {
    // It may have done anything to the sockets. At once, because callers wait in the new ones.
    listeners.try_to_open_again();
  }
  if (!told) {
    pause_ = lasted ? core::Duration{0}
                    : std::clamp<core::Duration>(2 * pause_, kFirstPause, kLongestPause);
    start_at_ = now_ + pause_;
    const bool goes_on = was_current && next_;  // the next one serves or fails
    if (!goes_on) local_.answer(std::exchange(restart_reply_, 0), "refused: " + wrong_);
  }
  if (stopping_.load() || std::exchange(first_told_, true)) return;
  first_.set_exception(std::make_exception_ptr(core::TransportError(wrong_)));
}

}  // namespace haptic::server
