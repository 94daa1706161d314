#pragma once
/// Samples on their way from a front's socket to their device's session, and the stops between
/// them. The link's thread takes them, and tells the front what came of each.

#include <vector>

#include "server/owner/link/from_front.hpp"
#include "server/owner/link/front_process.hpp"
#include "server/owner/link/publisher.hpp"
#include "server/owner/rights/owner.hpp"

namespace haptic::server {

class SampleIntake {
 public:
  /// Messages in one turn of the link: its other work comes between.
  static constexpr int kPerTurn = 32;

  /// Both must outlive this.
  SampleIntake(Owner& owner, Publisher& publisher);

  /// Takes at most kPerTurn messages, in order; stops go to front.stops. False: the front sent what
  /// no front sends, and is to be ended. A message is copied before the owner's lock is taken, so
  /// that no thread waits for a front.
  [[nodiscard]] bool take(FrontProcess& front);

 private:
  [[nodiscard]] bool take_one(FrontProcess& front, const Next& next);
  template <typename Sample>
  void judge(Sample& sample, std::vector<ArrivalOrder>& arrivals);

  Owner& owner_;
  Publisher& publisher_;
  ProxySample sample_{};                                      ///< scratch
  std::vector<ArrivalOrder> proxy_arrivals_, pose_arrivals_;  ///< per device
};

}  // namespace haptic::server
