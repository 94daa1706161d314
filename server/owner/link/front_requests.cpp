#include "server/owner/link/front_requests.hpp"

#include "server/crossing/link_messages.hpp"
#include "server/owner/link/from_front.hpp"

namespace haptic::server {

void FrontRequests::post(const FrontProcess& front, Request& request, core::TimePoint now) {
  using Kind = Request::Kind;
  request.id = request_id(front.generation, request.id);
  if (!make_harmless(request, now)) return;
  if (request.kind == Kind::kCancel) publisher_.forget_answer(request.id);
  const bool answered =
      request.kind != Kind::kCancel && request.kind != Kind::kClose && request.kind != Kind::kLose;
  if (!answered || publisher_.expect_answer(request.id)) owner_.post(request);
}

void FrontRequests::take_stops(FrontProcess& front, core::TimePoint now) {
  for (auto next = front.stops.begin(); next != front.stops.end();) {
    const auto stop = next++;
    // A front's own ids begin far above. Who asked is answered when the request has its turn.
    const std::uint64_t id = request_id(front.generation, stop->first);
    if (!publisher_.expect_answer(id)) continue;  // the one before is under way
    owner_.post(Request{.id = id,
                        .kind = Request::Kind::kStop,
                        .device = stop->first,
                        .text = stop->second,
                        .time = now});
    front.stops.erase(stop);
  }
}

}  // namespace haptic::server
