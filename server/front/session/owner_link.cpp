#include "server/front/session/owner_link.hpp"

#include <linux/futex.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <iterator>
#include <utility>

#include "haptic/core/error.hpp"
#include "server/base/thread_setup.hpp"

namespace haptic::server {
namespace {

/// A sign of life at least so often, also when nothing happens.
constexpr timespec kBeat{0, 250'000'000};
/// The owner takes messages within a millisecond: it has ended if it does not take one for so long.
constexpr int kPatienceMs = 5'000;

FrontConfig read_config(Descriptor& memory, std::uint64_t bytes) {
  if (bytes > kLargestConfig) {
    throw core::TransportError("front configuration: has " + std::to_string(bytes) +
                               " bytes: must have at most " + std::to_string(kLargestConfig));
  }
  const SharedMemory mapped(std::move(memory), bytes, SharedMemory::Access::kRead);
  return front_config({static_cast<const char*>(mapped.data()), bytes});
}

/// The descriptors from `begin` on.
std::vector<Descriptor> part(std::vector<Descriptor>& all, std::size_t begin, std::size_t count) {
  const auto first = std::make_move_iterator(all.begin() + static_cast<std::ptrdiff_t>(begin));
  return {first, first + static_cast<std::ptrdiff_t>(count)};
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
  if (descriptors.size() < OwnerMessage::kDescriptors) {
    throw core::TransportError("the owner's welcome: has " + std::to_string(descriptors.size()) +
                               " descriptors: must have at least " +
                               std::to_string(OwnerMessage::kDescriptors));
  }
  generation_ = welcome.generation;
  FrontStart start;
  start.config = read_config(descriptors[OwnerMessage::kConfig], welcome.config_bytes);
  const std::size_t sockets = sockets_of(start.config), files = files_of(start.config);
  const std::size_t all = OwnerMessage::kDescriptors + sockets + files;
  if (descriptors.size() != all) {
    throw core::TransportError("the owner's welcome: has " + std::to_string(descriptors.size()) +
                               " descriptors: must have " + std::to_string(all) +
                               " for its configuration");
  }
  start.sockets = part(descriptors, OwnerMessage::kDescriptors, sockets);
  start.files = part(descriptors, OwnerMessage::kDescriptors + sockets, files);
  take_pages(descriptors, start.config);
  return start;
}

void OwnerLink::take_pages(std::vector<Descriptor>& descriptors, const FrontConfig& config) {
  devices_ = config.devices;
  seen_.resize(devices_.size());
  own_ = SharedMemory(std::move(descriptors[OwnerMessage::kFrontsPages]), sizeof(FrontsPages),
                      SharedMemory::Access::kReadAndWrite);
  own_pages_ = static_cast<FrontsPages*>(own_.data());
  wakes_owner_ = std::move(descriptors[OwnerMessage::kWakesOwner]);
  owners_ = SharedMemory(std::move(descriptors[OwnerMessage::kOwnersPages]),
                         OwnersPages::bytes(devices_.size()), SharedMemory::Access::kRead);
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

OwnerMessage OwnerLink::hear() {
  for (;;) {
    pollfd wait{link_.get(), POLLIN, 0};
    poll(&wait, 1, -1);
    OwnerMessage message;
    switch (receive(link_.get(), message)) {
      case Received::kMessage:
        return message;
      case Received::kGone:
        return OwnerMessage{OwnerMessage::Kind::kLeave};
      case Received::kNothing:
      case Received::kOdd:
        continue;
    }
  }
}

void OwnerLink::wait_for_leave() {
  while (hear().kind != OwnerMessage::Kind::kLeave) continue;
  leaving_.store(true);
}

void OwnerLink::stop() {
  stopping_.store(true);
  if (thread_.joinable()) thread_.join();
}

FrontCounters OwnerLink::count(const FrontCounters& own) {
  FrontCounters all = pages_->counted.value();
  for (std::size_t i = 0; i < kFrontCounters; ++i) {
    own_pages_->counters[i].store(own[i], std::memory_order_relaxed);
    all[i] += own[i];
  }
  return all;
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
  if (request.kind == Kind::kStop && request.device < kMostDevices) {
    own_pages_->stops[request.device].fetch_add(1, std::memory_order_release);
  }
  if (!may_open(request)) {
    wake_owner();  // a stop is obeyed all the same
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

template <typename Box, typename Sample>
void OwnerLink::put(Box& box, const Sample& sample) {
  {
    const std::lock_guard lock(samples_mutex_);
    box.push(sample);
  }
  wake_owner();
}

void OwnerLink::post(const ProxySample& sample) {
  put(own_pages_->proxies, sample);
}

void OwnerLink::post(const PoseSample& pose) {
  put(own_pages_->poses, pose);
}

void OwnerLink::wake_owner() noexcept {
  static_cast<void>(eventfd_write(wakes_owner_.get(), 1));
}

DeviceStatus OwnerLink::status(std::size_t device) const {
  return pages_->devices.at(device).status.value();
}

void OwnerLink::run() noexcept {
  set_thread_up("owner link");
  while (!stopping_.load()) {
    const std::uint32_t heard = pages_->rings.load(std::memory_order_acquire);
    own_pages_->beats.fetch_add(1, std::memory_order_relaxed);
    pass_on();
    syscall(SYS_futex, &pages_->rings, FUTEX_WAIT, heard, &kBeat, nullptr, 0);
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
