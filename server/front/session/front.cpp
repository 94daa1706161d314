#include "server/front/session/front.hpp"

#include <algorithm>
#include <utility>

#include "server/front/session/refusals.hpp"

namespace haptic::server {

namespace {

/// Requests of several fronts must not have the same id.
std::uint64_t first_id() {
  static std::atomic<std::uint64_t> fronts{0};
  return ++fronts << 40;
}

}  // namespace

void EventQueue::push(const DeviceEvent& event) {
  const std::lock_guard lock(mutex_);
  if (events_.size() >= kCapacity) {
    // A staleness level is also a field of every state: it is lost first.
    const auto oldest = std::find_if(events_.begin(), events_.end(), [](const DeviceEvent& e) {
      return e.kind == DeviceEvent::Kind::kStaleness;
    });
    events_.erase(oldest == events_.end() ? events_.begin() : oldest);
    ++dropped_untold_;
  }
  events_.push_back(event);
}

std::optional<DeviceEvent> EventQueue::pop() {
  const std::lock_guard lock(mutex_);
  if (events_.empty()) return std::nullopt;
  DeviceEvent event = events_.front();
  events_.pop_front();
  if (dropped_untold_ > 0) {
    event.message = event.message.str() + " (" + std::to_string(dropped_untold_) +
                    " older events were dropped: this stream was not read)";
    dropped_untold_ = 0;
  }
  return event;
}

Front::Front(OwnerPort& owner)
    : owner_(owner), last_id_(first_id()), queues_(owner.devices().size()) {}

Outcome<std::size_t> Front::device(const std::string& name) const {
  const std::vector<DeviceFacts>& devices = owner_.devices();
  std::string names;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    if (devices[i].name == name || (name.empty() && devices.size() == 1)) return i;
    names += (i > 0 ? ", '" : "'") + devices[i].name + "'";
  }
  if (name.empty()) return invalid_field("device", "is empty: must be one of " + names);
  return Refusal{Refusal::Code::kNotFound, "NO_SUCH_DEVICE",
                 "device '" + sanitised(name, 64) + "': must be one of " + names, "device"};
}

std::uint64_t Front::ask(Request request, Answered answered, core::TimePoint until) {
  request.id = ++last_id_;
  {
    const std::lock_guard lock(mutex_);
    open_[request.id] = {std::move(answered), until};
  }
  owner_.post(request);
  return request.id;
}

Front::Answered Front::take(std::uint64_t id) {
  const std::lock_guard lock(mutex_);
  auto entry = open_.extract(id);
  return entry ? std::move(entry.mapped().answered) : Answered{};
}

void Front::give_up(core::TimePoint now) {
  std::vector<std::uint64_t> late;
  {
    const std::lock_guard lock(mutex_);
    for (const auto& [id, open] : open_) {
      if (open.until <= now) late.push_back(id);
    }
  }
  for (const std::uint64_t id : late) {
    const Answered answered = take(id);
    if (!answered) continue;
    owner_.post(Request{.id = id, .kind = Request::Kind::kCancel});
    answered({id, Refusal{Refusal::Code::kUnavailable, "NO_ANSWER",
                          "the loop gave no answer within 500 ms"}});
  }
}

void Front::on_answer(const Answer& answer) {
  if (const Answered answered = take(answer.id)) answered(answer);
}

std::uint64_t Front::ticket(const std::weak_ptr<SampleSource>& source) {
  const std::uint64_t ticket = ++last_id_;
  const std::lock_guard lock(mutex_);
  sources_[ticket] = source;
  return ticket;
}

void Front::forget(std::uint64_t ticket) {
  const std::lock_guard lock(mutex_);
  sources_.erase(ticket);
}

void Front::on_judged(const Judged& judged) {
  std::shared_ptr<SampleSource> source;
  {
    const std::lock_guard lock(mutex_);
    const auto entry = sources_.find(judged.ticket);
    if (entry != sources_.end()) source = entry->second.lock();
  }
  if (source) source->on_judged(judged);
}

std::shared_ptr<EventQueue> Front::subscribe(std::size_t device, core::TimePoint after) {
  auto queue = std::make_shared<EventQueue>();
  const std::lock_guard lock(mutex_);
  for (const auto& [its_device, event] : happened_) {
    const bool wanted = after != core::TimePoint{} && event.time > after;
    if (wanted && its_device == device) queue->push(event);
  }
  queues_[device].push_back(queue);
  return queue;
}

void Front::on_event(std::size_t device, const DeviceEvent& event) {
  const std::lock_guard lock(mutex_);
  if (happened_.size() == EventQueue::kCapacity) happened_.pop_front();
  happened_.emplace_back(device, event);
  std::erase_if(queues_[device], [&](const std::weak_ptr<EventQueue>& weak) {
    const auto queue = weak.lock();
    if (queue) queue->push(event);
    return !queue;
  });
}

}  // namespace haptic::server
