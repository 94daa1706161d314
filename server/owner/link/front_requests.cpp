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
  if (!front.queued && !publisher_.full()) return;
  for (std::size_t i = 0; i < owner_.devices().size(); ++i) {
    // The answer comes when its request has its turn.
    const std::uint32_t stop = front.pages.stops[i].load(std::memory_order_acquire);
    if (front.stops[i] == stop) continue;
    const std::uint64_t id = request_id(front.generation, i);  // a front's own begin far above
    if (!publisher_.expect_answer(id)) continue;               // the one before is under way
    front.stops[i] = stop;
    owner_.post(Request{.id = id,
                        .kind = Request::Kind::kStop,
                        .device = static_cast<std::uint32_t>(i),
                        .text = "over the network, ahead of the requests that wait",
                        .time = now});
  }
}

}  // namespace haptic::server
