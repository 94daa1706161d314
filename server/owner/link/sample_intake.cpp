#include "server/owner/link/sample_intake.hpp"

#include <thread>
#include <utility>

#include "server/base/steady_now.hpp"

namespace haptic::server {
SampleIntake::SampleIntake(Owner& owner, Publisher& publisher)
    : owner_(owner),
      publisher_(publisher),
      proxy_arrivals_(owner.devices().size()),
      pose_arrivals_(owner.devices().size()) {}

void SampleIntake::serve(const FrontsPages* pages) {
  {
    const Owner::Turn turn = owner_.turn();
    if (pages_ == pages) return;
    pages_ = pages;
    proxies_ = {};
    poses_ = {};
    proxies_taken_.store(0);
    poses_taken_.store(0);
    looked_at_.store(pages);
  }
  while (looking_.load()) std::this_thread::yield();
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

// Sequential consistency: either serve() sees that the loop looks, or the loop sees the new pages.
bool SampleIntake::sample_waits() noexcept {
  looking_.store(true);
  const FrontsPages* const pages = looked_at_.load();
  const bool waits =
      pages != nullptr && !(pages->proxies.taken(proxies_taken_.load(std::memory_order_relaxed)) &&
                            pages->poses.taken(poses_taken_.load(std::memory_order_relaxed)));
  looking_.store(false, std::memory_order_release);
  return waits;
}

void SampleIntake::take_for_tick() noexcept {
  if (!sample_waits()) return;
  if (const Owner::Turn turn = owner_.turn_if_free()) take(kPerTick, turn);
}

bool SampleIntake::take(int most, const Owner::Turn& turn) {
  if (pages_ == nullptr) return false;
  const std::uint64_t next_proxy = proxies_.next, next_pose = poses_.next;
  int proxies = 0, poses = 0;
  ProxySample& sample = sample_;
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
  if (proxies_.next != next_proxy) proxies_taken_.store(proxies_.next, std::memory_order_relaxed);
  if (poses_.next != next_pose) poses_taken_.store(poses_.next, std::memory_order_relaxed);
  return proxies == most || poses == most;
}

}  // namespace haptic::server
