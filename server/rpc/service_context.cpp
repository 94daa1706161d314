#include "server/rpc/service_context.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "server/rpc/status.hpp"

namespace haptic::server {

OpenStream::OpenStream(OpenStreams& streams) : streams_(streams) {
  const std::lock_guard lock(streams_.mutex_);
  ++streams_.alive_;
}

OpenStream::~OpenStream() {
  const std::lock_guard lock(streams_.mutex_);
  --streams_.alive_;
  streams_.gone_.notify_all();
}

void OpenStreams::add(const std::shared_ptr<OpenStream>& stream) {
  bool closing = false;
  {
    const std::lock_guard lock(mutex_);
    closing = closing_;
    std::erase_if(streams_, [](const auto& weak) { return weak.expired(); });
    streams_.push_back(stream);
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
  for (const auto& weak : streams_) {
    if (auto stream = weak.lock()) open.push_back(std::move(stream));
  }
  return open;
}

void OpenStreams::wait_until_gone() {
  std::unique_lock lock(mutex_);
  gone_.wait(lock, [&] { return alive_ == 0; });
}

ServiceContext::ServiceContext(RpcConfig rpc_config, std::vector<DeviceSessions*> device_sessions,
                               Telemetry& telemetry, FactsProvider facts_provider)
    : config(std::move(rpc_config)),
      devices(std::move(device_sessions)),
      facts(std::move(facts_provider)),
      registry(config.max_sessions),
      waiting(unopened_streams(config.max_sessions), config.open_within) {
  // A share for each device, so that the watchers of one cannot silence those of another.
  const WatchBudget share(config.watch_budget_hz /
                          static_cast<double>(std::max<std::size_t>(devices.size(), 1)));
  for (std::size_t i = 0; i < devices.size(); ++i) {
    broadcasters.push_back(std::make_unique<Broadcaster>(telemetry, i, share, *devices[i]));
  }
}

Outcome<ServiceContext::Target> ServiceContext::device(const std::string& name) const {
  std::string names;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    if (devices[i]->name() == name || (name.empty() && devices.size() == 1)) {
      return Target{devices[i], broadcasters[i].get()};
    }
    names += (i > 0 ? ", '" : "'") + devices[i]->name() + "'";
  }
  if (name.empty()) return invalid_field("device", "is empty: must be one of " + names);
  return Refusal{Refusal::Code::kNotFound, "NO_SUCH_DEVICE",
                 "device '" + sanitised(name, 64) + "': must be one of " + names, "device"};
}

void ServiceContext::end_overdue(core::TimePoint now) {
  const auto milliseconds =
      std::chrono::duration_cast<std::chrono::milliseconds>(waiting.patience());
  for (const auto& stream : waiting.overdue(now)) {
    stream->never_opened(
        {Refusal::Code::kInvalid, "PROTOCOL",
         "OpenSession did not come within " + std::to_string(milliseconds.count()) + " ms",
         "message"});
  }
}

void ServiceContext::add_weakness(std::string sentence) {
  const std::lock_guard lock(mutex_);
  weaknesses_.push_back(std::move(sentence));
}

std::vector<std::string> ServiceContext::weaknesses() const {
  const std::lock_guard lock(mutex_);
  return weaknesses_;
}

std::optional<Refusal> ServiceContext::check_rate(const char* field, double rate_hz) const {
  // A loop of 1 ms is 1000 Hz in words and 999.99... in doubles.
  const double most = std::round(loop_hz());
  if (rate_hz == 0.0 || (rate_hz >= 1.0 && rate_hz <= most)) return std::nullopt;
  return invalid_field(field, "= " + std::to_string(rate_hz) + ": must be 0, or 1.." +
                                  std::to_string(static_cast<int>(most)) + " Hz");
}

}  // namespace haptic::server
