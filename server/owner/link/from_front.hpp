#pragma once
/// Makes harmless what comes from a front, before anything looks at it: a front may be anybody's.
/// It may do no more than the most privileged client, and its times lie in the past.

#include "server/crossing/crossing.hpp"
#include "server/crossing/sample_socket.hpp"

namespace haptic::server {

/// Arrivals of one device's samples never go back, and never lie in the future.
class ArrivalOrder {
 public:
  [[nodiscard]] core::TimePoint in_order(core::TimePoint said, core::TimePoint now) noexcept;

 private:
  core::TimePoint newest_{};
};

/// Numbers beyond every enum become one within; times become `arrival`, or stay within what the
/// wire can say; texts become printable: what is no UTF-8 makes a whole message unreadable to
/// clients, also to those of the fronts that follow. Everything else is checked by the ingress and
/// the tracker.
void make_harmless(ProxySample& sample, core::TimePoint arrival) noexcept;
void make_harmless(PoseSample& sample, core::TimePoint arrival) noexcept;
void make_harmless(StopAhead& stop);
/// False: no request that a front may post.
[[nodiscard]] bool make_harmless(Request& request, core::TimePoint now);

}  // namespace haptic::server
