#include "server/front/service/service_context.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace haptic::server {
namespace {

/// A device whose loop gave no record for longer is not served.
constexpr core::Duration kSilence{std::chrono::milliseconds(500)};

}  // namespace

OpenStream::OpenStream(OpenStreams& streams) : streams_(streams) {
  const std::lock_guard lock(streams_.mutex_);
  ++streams_.alive_;
}

OpenStream::~OpenStream() {
  const std::lock_guard lock(streams_.mutex_);
  --streams_.alive_;
  streams_.streams_.erase(this);
  streams_.gone_.notify_all();
}

void OpenStreams::add(const std::shared_ptr<OpenStream>& stream) {
  bool closing = false;
  {
    const std::lock_guard lock(mutex_);
    closing = closing_;
    streams_[stream.get()] = stream;
  }
  if (closing) stream->server_closes();
}

void OpenStreams::close_all() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  for (const auto& stream : open()) stream->server_closes();
}

void OpenStreams::for_each(const std::function<void(OpenStream&)>& visit) const {
  for (const auto& stream : open()) visit(*stream);
}

std::vector<std::shared_ptr<OpenStream>> OpenStreams::open() const {
  std::vector<std::shared_ptr<OpenStream>> open;
  const std::lock_guard lock(mutex_);
  for (const auto& [name, weak] : streams_) {
    if (auto stream = weak.lock()) open.push_back(std::move(stream));
  }
  return open;
}

void OpenStreams::wait_until_gone() {
  std::unique_lock lock(mutex_);
  gone_.wait(lock, [&] { return alive_ == 0; });
}

std::shared_ptr<OpenStream> WaitingRoom::enter(const std::shared_ptr<OpenStream>& stream,
                                               core::TimePoint now) {
  std::shared_ptr<OpenStream> longest;
  const std::lock_guard lock(mutex_);
  if (guests_.size() >= places_) {
    longest = guests_.front().stream.lock();
    guests_.pop_front();
  }
  guests_.push_back({stream.get(), stream, now});
  return longest;
}

bool WaitingRoom::leave(const OpenStream& stream) {
  const std::lock_guard lock(mutex_);
  return std::erase_if(guests_, [&](const Guest& guest) { return guest.name == &stream; }) > 0;
}

std::vector<std::shared_ptr<OpenStream>> WaitingRoom::overdue(core::TimePoint now) {
  std::vector<std::shared_ptr<OpenStream>> answer;
  const std::lock_guard lock(mutex_);
  for (; !guests_.empty() && now - guests_.front().since >= patience_; guests_.pop_front()) {
    if (auto stream = guests_.front().stream.lock()) answer.push_back(std::move(stream));
  }
  return answer;
}

std::size_t WaitingRoom::waiting() const {
  const std::lock_guard lock(mutex_);
  return guests_.size();
}

ServiceContext::ServiceContext(FrontConfig front_config, OwnerPort& owner,
                               FactsProvider facts_provider, ServiceLimits service_limits)
    : Front(owner),
      config(std::move(front_config)),
      limits(std::move(service_limits)),
      server_facts(std::move(facts_provider)),
      waiting(unopened_streams(config.max_sessions), limits.open_within),
      former(std::max(1U, config.max_sessions / 2)) {
  // A share for each device, so that the watchers of one cannot silence those of another.
  const auto n = std::max<std::size_t>(owner.devices().size(), 1);
  const WatchBudget share(limits.watch_budget_hz / static_cast<double>(n));
  for (std::size_t i = 0; i < owner.devices().size(); ++i) {
    broadcasters.push_back(std::make_shared<Broadcaster>(i, share));
    owner.connect(broadcasters.back());
  }
}

std::shared_ptr<Account> ServiceContext::account_of(const std::string& peer) {
  auto account = connections->account(peer);
  if (account->calls() >= limits.connections.calls) connections->look_now();
  return account;
}

unsigned ServiceContext::sessions() const {
  unsigned all = 0;
  for (std::size_t i = 0; i < broadcasters.size(); ++i) all += owner().status(i).sessions;
  return all;
}

bool ServiceContext::serving(std::size_t device) const {
  const DeviceStatus status = owner().status(device);
  for (const core::Fault fault : {core::Fault::kDeviceSilent, core::Fault::kDeviceLost,
                                  core::Fault::kLoopLate, core::Fault::kLateBucketFull}) {
    if (status.faults.has(fault)) return false;
  }
  return status.state != core::LifecycleState::kInit &&
         status.state != core::LifecycleState::kClosing && steady_now() - status.ticked < kSilence;
}

bool ServiceContext::serving() const {
  for (std::size_t i = 0; i < owner().devices().size(); ++i) {
    if (!serving(i)) return false;
  }
  return true;
}

void ServiceContext::end_overdue(core::TimePoint now) {
  const auto milliseconds =
      std::chrono::duration_cast<std::chrono::milliseconds>(waiting.patience());
  for (const auto& stream : waiting.overdue(now)) {
    stream->end_with(
        {Refusal::Code::kInvalid, "PROTOCOL",
         "OpenSession did not come within " + std::to_string(milliseconds.count()) + " ms",
         "message"});
  }
}

}  // namespace haptic::server
