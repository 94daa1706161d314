#include "server/rpc/stop_round.hpp"

#include <mutex>

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
  std::vector<std::uint64_t> requests;
  std::shared_ptr<TickReply> reply;
};

void answered(Round& round, const std::string& device, const Answer& answer,
              grpc::ByteBuffer* response) {
  std::string failed;
  std::vector<std::string> stopped;
  {
    const std::lock_guard lock(round.mutex);
    if (!answer.refusal) {
      round.stopped.push_back(device);
    } else {
      round.failed += (round.failed.empty() ? "'" : ", '") + device + "'";
    }
    if (--round.open > 0) return;
    failed = round.failed;
    stopped = round.stopped;
  }
  if (!failed.empty()) {
    round.reply->finish(to_status({Refusal::Code::kUnavailable, "NO_ANSWER",
                                   "the loop did not confirm the stop of " + failed}));
    return;
  }
  round.reply->finish(grpc::Status::OK, [&] {
    v1::EmergencyStopResponse message;
    for (const std::string& name : stopped) message.add_stopped(name);
    *response = to_buffer(message);
  });
}

}  // namespace

void stop_all(Front& front, const std::vector<std::size_t>& devices, const std::string& reason,
              grpc::ServerUnaryReactor* reactor, grpc::ByteBuffer* response) {
  const auto round = std::make_shared<Round>();
  round->open = devices.size();
  round->reply = std::make_shared<TickReply>(reactor);
  for (const std::size_t device : devices) {
    Request stop;
    stop.kind = Request::Kind::kStop;
    stop.device = static_cast<std::uint32_t>(device);
    stop.text = reason;
    const std::uint64_t id =
        front.ask(stop, [round, name = front.facts(device).name, response](const Answer& answer) {
          answered(*round, name, answer, response);
        });
    const std::lock_guard lock(round->mutex);
    round->requests.push_back(id);
  }
  round->reply->watch([round, &front] {
    std::vector<std::uint64_t> requests;
    {
      const std::lock_guard lock(round->mutex);
      requests = round->requests;
    }
    for (const std::uint64_t id : requests) front.cancel(id);
  });
}

}  // namespace haptic::server
