#include "server/front/session/owner_link.hpp"

#include <linux/futex.h>
#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <iterator>
#include <utility>

#include "haptic/core/error.hpp"
#include "server/base/steady_now.hpp"
#include "server/base/thread_setup.hpp"

namespace haptic::server {
namespace {

/// A sign of life so often, also when nothing happens.
constexpr std::chrono::milliseconds kBeat{250};
constexpr timespec kLongestWait{0, 100'000'000};
/// The owner takes messages within a millisecond: it has ended if it does not take one for so long.
constexpr int kPatienceMs = 5'000;

FrontConfig read_config(Descriptor& memory, std::uint64_t bytes) {
  if (bytes > kLargestConfig) {
    throw core::TransportError("front configuration: has " + std::to_string(bytes) +
                               " bytes: must have at most " + std::to_string(kLargestConfig));
  }
  const SharedMemory mapped(std::move(memory), bytes);
  return front_config({static_cast<const char*>(mapped.data()), bytes});
}

void check_count(const char* of, std::size_t has, const char* must, std::size_t wanted) {
  if (has == wanted || (has > wanted && *must != '\0')) return;
  throw core::TransportError(std::string("the owner's ") + of + ": has " + std::to_string(has) +
                             " descriptors: must have " + must + std::to_string(wanted));
}

}  // namespace

FrontStart OwnerLink::hello() {
  FrontMessage hello;
  hello.layout = layout_hash();
  say(hello);
  pollfd wait{link_.get(), POLLIN, 0};
  poll(&wait, 1, kPatienceMs);
  OwnerMessage welcome;
  std::vector<Descriptor> descriptors;
  if (receive(link_.get(), welcome, &descriptors) != Received::kMessage ||
      welcome.kind != OwnerMessage::Kind::kWelcome) {
    throw core::TransportError("the owner does not want this front");
  }
  check_count("welcome", descriptors.size(), "at least ", OwnerMessage::kDescriptors);
  generation_ = welcome.generation;
  FrontStart start;
  start.config = read_config(descriptors[OwnerMessage::kConfig], welcome.config_bytes);
  check_count("welcome", descriptors.size(), "",
              OwnerMessage::kDescriptors + files_of(start.config));
  sockets_ = sockets_of(start.config);
  start.files.assign(std::make_move_iterator(descriptors.begin() + OwnerMessage::kDescriptors),
                     std::make_move_iterator(descriptors.end()));
  take_pages(descriptors, start.config);
  return start;
}

void OwnerLink::take_pages(std::vector<Descriptor>& descriptors, const FrontConfig& config) {
  devices_ = config.devices;
  seen_.resize(devices_.size());
  samples_ = std::make_unique<SampleSender>(std::move(descriptors[OwnerMessage::kSamples]));
  owners_ = SharedMemory(std::move(descriptors[OwnerMessage::kOwnersPages]),
                         OwnersPages::bytes(devices_.size()));
  pages_ = static_cast<const OwnersPages*>(owners_.data());
}

OwnerLink::~OwnerLink() {
  stop();
}

void OwnerLink::begin() {
  answers_ = pages_->answers.begin(0);
  events_ = pages_->events.begin(kRetold);
  judged_ = pages_->judged.begin(0);
  pass_on();  // before any session is there: the past is told only to those that ask for it
  thread_ = std::thread([this] { run(); });
}

bool OwnerLink::say(const FrontMessage& message) {
  while (!send(link_.get(), message)) {
    if (errno != EAGAIN) return false;
    pollfd wait{link_.get(), POLLOUT, 0};
    if (poll(&wait, 1, kPatienceMs) <= 0) return false;
  }
  return true;
}

std::optional<std::vector<Descriptor>> OwnerLink::wait_for_go() {
  std::vector<Descriptor> sockets;
  if (hear(sockets).kind != OwnerMessage::Kind::kGo) return std::nullopt;
  check_count("go", sockets.size(), "", sockets_);
  return sockets;
}

OwnerMessage OwnerLink::hear(std::vector<Descriptor>& brought) {
  for (;;) {
    pollfd wait{link_.get(), POLLIN, 0};
    poll(&wait, 1, -1);
    OwnerMessage message;
    switch (receive(link_.get(), message, &brought)) {
      case Received::kMessage:
        return message;
      case Received::kGone:
        return OwnerMessage{OwnerMessage::Kind::kLeave};
      case Received::kNothing:
      case Received::kOdd:
      case Received::kBurdened:
        continue;
    }
  }
}

void OwnerLink::wait_for_leave() {
  std::vector<Descriptor> none;
  while (hear(none).kind != OwnerMessage::Kind::kLeave) continue;
  leaving_.store(true);
}

void OwnerLink::stop() {
  stopping_.store(true);
  if (thread_.joinable()) thread_.join();
}

FrontCounters OwnerLink::count(const FrontCounters& own) {
  {
    const std::lock_guard lock(mutex_);
    own_ = own;
  }
  beat();  // so that no later front counts from less than was shown
  FrontCounters all = pages_->counted.value();
  for (std::size_t i = 0; i < kFrontCounters; ++i) all[i] += own[i];
  return all;
}

void OwnerLink::beat() {
  FrontMessage message{.kind = FrontMessage::Kind::kBeat};
  const std::lock_guard lock(mutex_);
  message.counters = own_;
  send(link_.get(), message);
}

bool OwnerLink::may_open(const Request& request) {
  using Kind = Request::Kind;
  const std::lock_guard lock(mutex_);
  if (request.kind == Kind::kCancel) open_.erase(request.id);
  if (request.kind == Kind::kCancel || request.kind == Kind::kClose ||
      request.kind == Kind::kLose) {
    return true;
  }
  const std::size_t stops = request.kind == Kind::kStop ? kMostOpenStops : 0;
  if (open_.size() >= kMostOpenRequests + stops) return false;
  open_.insert(request.id);
  return true;
}

void OwnerLink::refuse(const Request& request, const Refusal& why) {
  const Answer answer{request.id, why};
  for (const auto& front : fronts()) front->on_answer(answer);
}

void OwnerLink::post(const Request& request) {
  using Kind = Request::Kind;
  if (leaving_.load() && (request.kind == Kind::kClose || request.kind == Kind::kLose)) return;
  if (request.kind == Kind::kStop) samples_->send(StopAhead{request.device, request.text});
  if (!may_open(request)) {  // a stop is obeyed all the same
    return refuse(request, {Refusal::Code::kExhausted, "TOO_MANY_REQUESTS",
                            "too many requests wait for an answer"});
  }
  if (say({.kind = FrontMessage::Kind::kRequest, .request = request})) return;
  {
    const std::lock_guard lock(mutex_);
    if (open_.erase(request.id) == 0 && request.kind != Kind::kStop) return;
  }
  refuse(request,
         {Refusal::Code::kUnavailable, "NO_ANSWER", "the owner of the devices takes no requests"});
}

DeviceStatus OwnerLink::status(std::size_t device) const {
  return pages_->devices.at(device).status.value();
}

void OwnerLink::run() noexcept {
  set_thread_up("owner link");
  while (!stopping_.load()) {
    const std::uint32_t heard = pages_->rings.load(std::memory_order_acquire);
    if (const core::TimePoint now = steady_now(); now >= beat_due_) {
      beat_due_ = now + kBeat;
      beat();
    }
    samples_->flush();
    pass_on();
    syscall(SYS_futex, &pages_->rings, FUTEX_WAIT, heard, &kLongestWait, nullptr, 0);
  }
}

void OwnerLink::pass_on() {
  const Fronts fronts = this->fronts();
  // An event that happened before an answer was written comes before that answer.
  const std::uint64_t answered = pages_->answers.head();
  Happened happened;
  while (pages_->events.read(events_, happened)) {
    if (happened.device >= devices_.size()) continue;
    for (const auto& front : fronts) front->on_event(happened.device, happened.event);
  }
  Answer answer;
  while (answers_.next < answered && pages_->answers.read(answers_, answer)) {
    if (answer.id != request_id(generation_, answer.id)) continue;  // another front's
    answer.id &= kFrontsId;
    {
      const std::lock_guard lock(mutex_);
      open_.erase(answer.id);
    }
    for (const auto& front : fronts) front->on_answer(answer);
  }
  Judged judged;
  while (pages_->judged.read(judged_, judged)) {
    for (const auto& front : fronts) front->on_judged(judged);
  }
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    if (!pages_->devices[i].state.newer(seen_[i], newest_)) continue;
    for (const auto& front : fronts) front->on_newest(i, newest_);
  }
}

}  // namespace haptic::server
