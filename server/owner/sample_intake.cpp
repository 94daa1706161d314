#include "server/owner/sample_intake.hpp"

#include <utility>

#include "server/base/steady_now.hpp"

namespace haptic::server {

SampleIntake::SampleIntake(Owner& owner, Publisher& publisher)
    : owner_(owner),
      publisher_(publisher),
      proxy_arrivals_(owner.devices().size()),
      pose_arrivals_(owner.devices().size()) {}

void SampleIntake::serve(const FrontsPages* pages) {
  const Owner::Turn turn = owner_.turn();
  if (pages_ == pages) return;
  pages_ = pages;
  proxies_ = {};
  poses_ = {};
}

bool SampleIntake::take() {
  bool more = false;
  bool tell = false;
  {
    const Owner::Turn turn = owner_.turn();
    more = take(kPerTurn, turn);
    tell = std::exchange(told_, judged_) != judged_;
  }
  if (tell) publisher_.ring();
  return more;
}

void SampleIntake::take_for_tick() noexcept {
  if (const Owner::Turn turn = owner_.turn_if_free()) take(kPerTick, turn);
}

bool SampleIntake::take(int most, const Owner::Turn& turn) {
  if (pages_ == nullptr) return false;
  int proxies = 0, poses = 0;
  ProxySample sample;
  for (; proxies < most && pages_->proxies.take(proxies_, sample); ++proxies) {
    if (sample.device >= proxy_arrivals_.size()) continue;
    make_harmless(sample, proxy_arrivals_[sample.device].in_order(sample.arrival, steady_now()));
    publisher_.judged({sample.ticket, sample.seq, sample.carrier, owner_.accept(sample, turn)});
    ++judged_;
  }
  PoseSample pose;
  for (; poses < most && pages_->poses.take(poses_, pose); ++poses) {
    if (pose.device >= pose_arrivals_.size()) continue;
    make_harmless(pose, pose_arrivals_[pose.device].in_order(pose.arrival, steady_now()));
    publisher_.judged({pose.ticket, pose.seq, Carrier::kGrpc, owner_.accept(pose, turn)});
    ++judged_;
  }
  return proxies == most || poses == most;
}

}  // namespace haptic::server
