#include "server/rpc/stop_round.hpp"

#include <mutex>
#include <utility>

#include "haptic/v1/haptic_service.pb.h"
#include "server/rpc/state_frame.hpp"
#include "server/rpc/status.hpp"
#include "server/rpc/tick_reply.hpp"

namespace haptic::server {
namespace {

struct Round {
  std::mutex mutex;
  std::size_t open{0};
  std::vector<std::string> stopped;
  std::string failed;  ///< devices whose loop did not answer
  std::vector<std::pair<DeviceSessions*, Ticket>> tickets;
  std::shared_ptr<TickReply> reply;
};

void answered(Round& round, const DeviceSessions& device, const Outcome<Done>& outcome,
              grpc::ByteBuffer* response) {
  std::string failed;
  std::vector<std::string> stopped;
  {
    const std::lock_guard lock(round.mutex);
    if (outcome) {
      round.stopped.push_back(device.name());
    } else {
      round.failed += (round.failed.empty() ? "'" : ", '") + device.name() + "'";
    }
    if (--round.open > 0) return;
    failed = round.failed;
    stopped = round.stopped;
  }
  if (!failed.empty()) {
    round.reply->finish(to_status({Refusal::Code::kUnavailable,
                                   "NO_ANSWER",
                                   "the loop did not confirm the stop of " + failed,
                                   {}}));
    return;
  }
  round.reply->finish(grpc::Status::OK, [&] {
    v1::EmergencyStopResponse message;
    for (const std::string& name : stopped) message.add_stopped(name);
    *response = to_buffer(message);
  });
}

}  // namespace

void stop_all(const std::vector<DeviceSessions*>& devices, const std::string& reason,
              grpc::ServerUnaryReactor* reactor, grpc::ByteBuffer* response) {
  const auto round = std::make_shared<Round>();
  round->open = devices.size();
  round->reply = std::make_shared<TickReply>(reactor);
  for (DeviceSessions* device : devices) {
    const Ticket ticket =
        device->emergency_stop(reason, [round, device, response](const Outcome<Done>& outcome) {
          answered(*round, *device, outcome, response);
        });
    const std::lock_guard lock(round->mutex);
    round->tickets.emplace_back(device, ticket);
  }
  round->reply->watch([round] {
    std::vector<std::pair<DeviceSessions*, Ticket>> tickets;
    {
      const std::lock_guard lock(round->mutex);
      tickets = round->tickets;
    }
    for (const auto& [device, ticket] : tickets) device->cancel(ticket);
  });
}

}  // namespace haptic::server
