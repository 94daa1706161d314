#pragma once
/// Passes requests of a front on to the owner, made harmless (from_front.hpp), and no more of them
/// than an honest front has open. It knows no thread: the front link calls it.

#include "server/owner/link/front_process.hpp"
#include "server/owner/link/publisher.hpp"

namespace haptic::server {

class FrontRequests {
 public:
  /// Both must outlive this.
  FrontRequests(Owner& owner, Publisher& publisher) : owner_(owner), publisher_(publisher) {}

  /// A request that came as a message.
  void post(const FrontProcess& front, Request& request, core::TimePoint now);
  /// Stops that came ahead of their requests.
  void take_stops(FrontProcess& front, core::TimePoint now);

 private:
  Owner& owner_;
  Publisher& publisher_;
};

}  // namespace haptic::server
